"""Several dispatchers, one database, one farm, many jobs: each job is one dispatcher's at a time."""

from __future__ import annotations

import signal
from collections.abc import Callable
from itertools import cycle
from pathlib import Path
from typing import Any

import pytest
from tests.farm.harness import wait_until
from tests.server.test_postgres import claimed

from .checks import Picture, check_files, check_picture, check_states, eventually
from .faults import NODE1
from .rig import Rig
from .strikes import stop_between_writes

pytestmark = [pytest.mark.chaos, pytest.mark.xdist_group("postgresql farm")]

#: What jobs ask for.
DEVICES = [NODE1, "any"]

Check = Callable[[dict[str, str]], None]


@pytest.fixture
def rig(rigs: Callable[[str, str], Rig]) -> Rig:
    return rigs("farm", "postgresql")


@pytest.fixture
def check(rig: Rig, undisturbed: Callable[[Rig, str], Picture]) -> Check:
    """Jobs, by what device they ask for, come to their ends, with every sample once."""
    expected = {device: undisturbed(rig, device) for device in DEVICES}

    def check(jobs: dict[str, str]) -> None:
        wait_until(lambda: all(map(rig.ended, jobs)), 120)
        for job_id, device in jobs.items():
            check_states(rig, job_id)
            check_picture(rig, job_id, expected[device], device != "any")
            eventually(lambda job_id=job_id: check_files(rig, job_id), 5)

    return check


def test_no_job_is_taken_twice(rig: Rig, body: Callable[[str], dict[str, Any]], check: Check) -> None:
    rig.spoilt = True  # until all is well
    services = cycle(rig.alive)
    jobs = {next(services).submit(**body(device)): device for device in DEVICES * 6}
    check(jobs)
    one, other = ([job for job in claimed(service) if job in jobs] for service in rig.services.values())
    assert sorted(one + other) == sorted(jobs)
    assert one
    assert other
    rig.spoilt = False


def test_a_dispatcher_that_was_stopped_changes_nothing(
    rig: Rig, body: Callable[[str], dict[str, Any]], check: Check
) -> None:
    """It has a Film in its hands when it goes on, while another one is in the middle of the job."""

    def row(job_id: str) -> tuple[Any, ...]:
        columns = "state, samples, seconds, series, usage, spent, kept, error, token, holder"
        (row,) = rig.rows(f"SELECT {columns} FROM jobs WHERE id = :id", id=job_id)
        return tuple(row)

    def contents(job_id: str) -> dict[str, tuple[Path, bytes]]:
        return {name: (path, path.read_bytes()) for name, path in rig.files(job_id).items()}

    rig.spoilt = True  # until all is well
    rig.gates.arm("mid-range")
    job_id = rig.alive[0].submit(**body(NODE1))
    one = rig.target(job_id, rig.gates.reached("mid-range"))
    process = stop_between_writes(rig, one)
    rig.gates.open()
    wait_until(lambda: rig.gates.passed("mid-range"), 10)
    rig.gates.arm("merged")
    other = rig.target(job_id, rig.gates.reached("merged"))
    assert other.service is not one.service
    later = {other.service.submit(**body(device)): device for device in DEVICES * 2}
    before, files = row(job_id), contents(job_id)
    process.send_signal(signal.SIGCONT)
    lost = f"job lost to another dispatcher job={job_id}"
    wait_until(lambda: lost in one.service.log.read_text(), 15)
    assert row(job_id) == before
    assert contents(job_id) == files
    rig.gates.open()
    check({job_id: NODE1, **later})
    assert (claimed(one.service).count(job_id), claimed(other.service).count(job_id)) == (1, 1)
    rig.spoilt = False
