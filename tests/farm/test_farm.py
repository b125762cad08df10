"""A farm on this machine: scheduler, workers and service as processes of their own that speak TLS."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any

import pytest

from .harness import PIECES, SLOWLY, Farm, Part, wait_until

Make = Callable[..., dict[str, Any]]


def ended(job: dict[str, Any]) -> bool:
    """`Service.wait` tells why one failed, unless that is waited for."""
    return job["state"] == "succeeded"


@pytest.mark.slow
def test_a_job_is_rendered_by_a_worker_that_comes_late(farm: Farm, make_scene: Make) -> None:
    service = farm.start_service()
    answer = service.http.get("/readyz")
    assert answer.status_code == 503
    assert "No worker with a device is connected to the scheduler" in answer.json()["detail"]
    waiting = service.submit(make_scene(), "cpu")
    farm.start_worker("node1")
    farm.wait_for(service, "cpu0@node1")
    job = service.wait(waiting, ended, 120)
    assert (job["state"], job["devices"]) == ("succeeded", ["cpu0@node1"])
    (device,) = service.http.get("/api/v1/devices").json()["items"]
    assert (device["id"], device["host"], device["state"]) == ("cpu0@node1", "node1", "ready")
    assert service.http.get("/readyz").json()["devices"] == 1
    assert farm.workers["node1"].stop() == 0
    assert farm.scheduler.stop(signal.SIGINT) == 0


@pytest.mark.slow
def test_a_job_keeps_a_device_that_a_check_waits_for(farm: Farm, make_scene: Make) -> None:
    """Also where the device goes and comes back meanwhile."""
    service = farm.start_service(prelude=PIECES)
    farm.start_worker("node1", SLOWLY)
    farm.wait_for(service, "cpu0@node1")
    job_id = service.submit(make_scene(samples=64 * 24), "cpu0@node1")
    service.wait(job_id, lambda job: job["samples"] > 0)
    service.http.post("/api/v1/devices/cpu0@node1/stability").raise_for_status()
    port = int(farm.environment["WOODCOCK_SCHEDULER"].rpartition(":")[2])
    farm.scheduler.stop(signal.SIGKILL)
    wait_until(lambda: "does not answer" in service.http.get("/readyz").text, 30, farm.logs)
    farm.start_scheduler(port=port)
    service.wait(job_id, ended, 60)
    report = service.http.get(f"/api/v1/jobs/{job_id}/report.json").json()
    assert report["sample_ranges"] == [[0, 64 * 24]]


@pytest.mark.slow
def test_commands_say_what_is_missing(farm: Farm) -> None:
    def says(command: str, *options: str, **environment: str) -> str:
        part = Part(farm.folder / "other", command, *options, **environment)
        with part.process:
            assert part.process.wait(60) == 2
        return part.log.read_text()

    assert "WOODCOCK_CERTIFICATES (or --certificates): the folder" in says("scheduler")
    assert "WOODCOCK_SCHEDULER (or --scheduler): whose" in says("worker", "--certificates", str(farm.certificates))
    assert "WOODCOCK_WORKER_NAME (or --name): String" in says("worker", "--name", "a/b")
    assert "is there already; remove it" in says("certificates", str(farm.certificates))
