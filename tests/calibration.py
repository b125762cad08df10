"""A calibration run: statistical tests with fresh seeds, several rounds of them, and whether p-values are uniform.

    python -m pytest -p tests.calibration [--rounds N] [--run-seed TEXT] [FILE ...]

Fresh seeds reach a test through the fixtures `picture` and `rng`: tests that have neither are left out, and so are
further rounds of those that made no exact comparison in their first.
"""

from __future__ import annotations

import json
import re
import secrets
from collections.abc import Iterable

import numpy as np
import pytest
from scipy.stats import kstest
from tests import statistics
from tests.statistics import Comparison

#: Probability that a calibration run fails by chance.
FAMILY_WISE = 1e-3
#: Exact p-values that make a group which is held to the law by itself, and a test that is named when one fails.
GROUP, TEST = 20, 5

Groups = dict[str, list[Comparison]]
REPORT = pytest.StashKey[list[str]]()
#: Tests that made an exact comparison, less their rounds.
exact_tests: set[str] = set()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("calibration")
    group.addoption("--rounds", type=int, default=4, help="how often every test runs, each time with other seeds")
    group.addoption("--run-seed", default=secrets.token_hex(8), help="what all seeds are made of")


def pytest_configure(config: pytest.Config) -> None:
    statistics.FRESH = config.getoption("--run-seed")


def pytest_report_header(config: pytest.Config) -> str:
    return f"calibration: {config.getoption('--rounds')} rounds, --run-seed {statistics.FRESH}"


@pytest.fixture(autouse=True)
def calibration_round(request: pytest.FixtureRequest) -> int:
    """Makes every round a test of its own, whose name says the round: seeds are made of names."""
    return int(request.param)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    rounds = range(metafunc.config.getoption("--rounds"))
    metafunc.parametrize("calibration_round", rounds, indirect=True, ids=[f"round{turn}" for turn in rounds])


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    random = [item for item in items if {"picture", "rng"}.intersection(getattr(item, "fixturenames", ()))]
    config.hook.pytest_deselected(items=[item for item in items if item not in random])
    items[:] = random


def without_round(test: str) -> str:
    return re.sub(r"(\[)?-?round\d+(?(1)-?)", r"\1", test)


def pytest_runtest_setup(item: pytest.Item) -> None:
    if "round0" not in item.nodeid and without_round(item.nodeid) not in exact_tests:
        pytest.skip("makes no exact comparison")


def pytest_runtest_teardown(item: pytest.Item) -> None:
    for comparison in reversed(statistics.COMPARISONS):
        if comparison.test != item.nodeid:
            break
        if comparison.exact:
            exact_tests.add(without_round(item.nodeid))


def uniformity(comparisons: Iterable[Comparison]) -> tuple[float, float]:
    """Kolmogorov & Smirnov's statistic and its p-value."""
    found = kstest([comparison.p for comparison in comparisons], "uniform")
    return float(found.statistic), float(found.pvalue)


def grouped(comparisons: Iterable[Comparison], pattern: str) -> Groups:
    """By what a regular expression finds in the test's name."""
    groups: Groups = {}
    for comparison in comparisons:
        found = re.match(pattern, comparison.test)
        groups.setdefault(found.group() if found else "", []).append(comparison)
    return groups


def judged(comparisons: list[Comparison]) -> tuple[list[str], list[str]]:
    """A table of all exact p-values, and of those by folder and by file; and what is wrong, with the worst tests."""
    exact = [comparison for comparison in comparisons if comparison.exact]
    groups = {"all": exact, **grouped(exact, r".*/"), **grouped(exact, r"[^:]*")}
    groups = {name: group for name, group in groups.items() if len(group) >= GROUP}
    level = -np.expm1(np.log1p(-FAMILY_WISE) / max(len(groups), 1))
    table = [f"{len(comparisons)} p-values, {len(exact)} of them exact; each group at level {level:.2g}"]
    wrong = [] if groups else ["there are too few p-values to say anything"]
    for name, group in groups.items():
        d, p = uniformity(group)
        table.append(f"{name:45} n = {len(group):5}  D = {d:.4f}  p = {p:.3g}")
        if p < level:
            wrong.append(f"{name}: p-values are not uniform, p = {p:.3g}; the tests furthest from it:")
            tests = [g for g in grouped(group, r"[^\[]*").values() if len(g) >= TEST]
            for test in sorted(tests, key=lambda test: uniformity(test)[1])[:3]:
                d, p = uniformity(test)
                ends = "pushed to 0" if np.mean([c.p for c in test]) < 0.5 else "pushed to 1"
                wrong.append(f"    {test[0].test.partition('[')[0]} n = {len(test)} D = {d:.4f} p = {p:.3g}, {ends}")
    return table, wrong


def pytest_sessionfinish(session: pytest.Session) -> None:
    file = session.config.rootpath / session.config.getini("cache_dir") / "p-values.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    rows = [comparison._asdict() for comparison in statistics.COMPARISONS]
    file.write_text(json.dumps({"run_seed": statistics.FRESH, "comparisons": rows}, indent=0))
    table, wrong = judged(statistics.COMPARISONS)
    session.config.stash[REPORT] = [*table, *wrong, f"all p-values: {file}"]
    if wrong:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    terminalreporter.section(f"calibration, --run-seed {statistics.FRESH}")
    for line in config.stash[REPORT]:
        terminalreporter.line(line)
