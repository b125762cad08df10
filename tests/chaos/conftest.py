"""Rigs, one at a time, and the table of what was survived."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from tests.farm.harness import wait_until
from tests.server.conftest import make_scene as make_scene
from tests.server.conftest import postgres as postgres

from .checks import SAMPLES, SIZE, Picture, picture
from .rig import Rig
from .rigs import RIGS
from .table import table


@pytest.fixture(scope="session")
def rigs(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Callable[[str, str], Rig]]:
    """The rig of a kind on a database: the last one, if it is of these and well."""
    last: tuple[str, str] | None = None
    rig: Rig | None = None

    def get(kind: str, database: str) -> Rig:
        nonlocal last, rig
        if rig is not None and (last != (kind, database) or len(rig.alive) < len(rig.services) or rig.spoilt):
            rig.close()
            rig = None
        if rig is None:
            url = request.getfixturevalue("postgres")() if database == "postgresql" else None
            rig = RIGS[kind](url, tmp_path_factory.mktemp("rig"))
            last = kind, database
        rig.settle()
        return rig

    yield get
    if rig is not None:
        rig.close()


@pytest.fixture(scope="session")
def body(make_scene: Callable[..., dict[str, Any]]) -> Callable[[str], dict[str, Any]]:
    """What is asked for: a job for a device."""
    return lambda device: {"scene": make_scene(size=SIZE, samples=SAMPLES), "device": device}


@pytest.fixture(scope="session")
def undisturbed(body: Callable[[str], dict[str, Any]]) -> Callable[[Rig, str], Picture]:
    """The picture that no fault disturbed, by what device it asks for; rendered when it is first needed."""
    known: dict[str, Picture] = {}

    def get(rig: Rig, device: str) -> Picture:
        while device not in known:
            service = rig.alive[0]
            # The first is begun on the generic program, whose sums are others.
            for _ in range(2):
                answer = service.http.post("/api/v1/jobs", json=body(device))
                job_id = answer.raise_for_status().json()["id"]
                wait_until(lambda job_id=job_id: rig.ended(job_id), 60)
            known[device] = picture(rig, job_id)
        return known[device]

    return get


def pytest_terminal_summary(terminalreporter: Any) -> None:
    reports = [
        report
        for kind in ("passed", "failed", "error", "skipped")
        for report in terminalreporter.stats.get(kind, [])
        if "cell" in dict(getattr(report, "user_properties", ()))
    ]
    if any("chaos" in report.keywords for report in reports):
        terminalreporter.section("chaos")
        terminalreporter.write_line(table(reports))
