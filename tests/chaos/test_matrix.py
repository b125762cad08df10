"""Every fault at every stage, on every database: the job comes to its end, and nothing tells what was amiss."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from tests.farm.harness import wait_until

from .checks import (
    Picture,
    check_answers,
    check_files,
    check_picture,
    check_states,
    eventually,
)
from .faults import FAULTS, Fault
from .rig import Rig
from .stages import STAGES

#: What `make test` runs of it.
ALWAYS = {("sqlite", "dispatcher cancelled", "merged")}


def cells() -> Iterator[Any]:
    """By the rigs that they need, so that each is made once; several processes share them out by these."""
    for database in ("sqlite", "postgresql"):
        for fault in sorted(FAULTS, key=lambda fault: fault.rig):
            for stage in STAGES:
                if not {stage, database} & fault.left_out.keys():
                    marks = [pytest.mark.xdist_group(f"{database} {fault.rig}")]
                    marks += [] if (database, fault.name, stage) in ALWAYS else [pytest.mark.chaos]
                    yield pytest.param(
                        database, fault, stage, marks=marks, id=f"{database}-{fault.name}-{stage}".replace(" ", "-")
                    )


@pytest.mark.parametrize(("database", "fault", "stage"), list(cells()))
def test_a_fault_is_survived(
    database: str,
    fault: Fault,
    stage: str,
    rigs: Callable[[str, str], Rig],
    body: Callable[[str], dict[str, Any]],
    undisturbed: Callable[[Rig, str], Picture],
    record_property: Callable[[str, object], None],
    request: pytest.FixtureRequest,
) -> None:
    record_property("cell", (database, fault.name, stage))
    rig = rigs(fault.rig, database)
    expected = undisturbed(rig, fault.device)
    rig.spoilt = True  # until all is well
    rig.gates.arm(stage)
    asked, key = body(fault.device), f"{request.node.name}-{time.time_ns()}".replace(" ", "-")
    answer = rig.alive[0].http.post("/api/v1/jobs", json=asked, headers={"Idempotency-Key": key})
    assert answer.status_code == 201, answer.text
    job_id = answer.json()["id"]
    target = rig.target(job_id, rig.gates.reached(stage))
    try:
        with fault.strike(rig, target):
            rig.gates.open()
            time.sleep(fault.lasts)
        wait_until(lambda: rig.ended(job_id), 90)
        walk = check_states(rig, job_id)
        check_picture(rig, job_id, expected, fault.device != "any")
        eventually(lambda: check_files(rig, job_id), 5)
        check_answers(rig, job_id, asked, key, walk)
        assert stage != "ended" or f"job lost to another dispatcher job={job_id}" not in rig.log, "it had ended"
    except BaseException:
        print(rig.log)
        raise
    rig.spoilt = False
