"""A plugin of pytest's: stops at the first test that fails by its own assertion, and writes down what happened.

Only such a failure says that a test noticed something: a program that does not build, a fault on the way or a time that
ran out would notice any change.
"""

from __future__ import annotations

import json
from collections.abc import Generator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

PACKAGES = {"woodcock": "kernels", "woodcock_server": "server", "woodcock_client": "client"}
VERDICT = pytest.StashKey[dict[str, Any]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--verdict", type=Path, required=True, help="the file to write it to")


def pytest_configure(config: pytest.Config) -> None:
    for package, folder in PACKAGES.items():
        spec = find_spec(package)
        if spec is None or spec.origin is None or not Path(spec.origin).is_relative_to(config.rootpath / folder):
            raise pytest.UsageError(f"{package} is not that of {config.rootpath}: {spec and spec.origin}")
    config.stash[VERDICT] = {"passed": 0, "caught": None, "says": "", "broken": []}


def is_assertion(error: pytest.ExceptionInfo[BaseException], root: Path) -> bool:
    """Raised by an assertion of a test, not by one of the program's; or by `pytest.raises`, in vain."""
    if isinstance(error.value, pytest.fail.Exception):
        return str(error.value).startswith("DID NOT RAISE")
    raised = Path(str(error.traceback[-1].path))
    inside = any(raised.is_relative_to(root / folder) for folder in PACKAGES.values())
    return isinstance(error.value, AssertionError) and not inside


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    verdict = item.config.stash[VERDICT]
    if report.passed and report.when == "call":
        verdict["passed"] += 1
    elif report.failed and call.excinfo is not None:
        if report.when == "call" and is_assertion(call.excinfo, item.config.rootpath):
            verdict["caught"], verdict["says"] = item.nodeid, call.excinfo.exconly().splitlines()[0]
            item.session.shouldstop = "caught"
        else:
            verdict["broken"].append(f"{item.nodeid}: {call.excinfo.exconly().splitlines()[0]}")
    return report


def pytest_sessionfinish(session: pytest.Session) -> None:
    session.config.getoption("--verdict").write_text(json.dumps(session.config.stash[VERDICT]))
