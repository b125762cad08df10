"""A farm on this machine: scheduler, workers and service as processes of their own that speak TLS."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from woodcock_server import certificate
from woodcock_server.command import serve

from .harness import PIECES, SLOWLY, Farm, Part, wait_until

Make = Callable[..., dict[str, Any]]

service_app = typer.Typer()
service_app.command()(serve)


def ended(job: dict[str, Any]) -> bool:
    """`Service.wait` tells why one failed, unless that is waited for."""
    return job["state"] == "succeeded"


@pytest.mark.slow
def test_a_job_is_rendered_by_a_worker_that_comes_late(farm: Farm, make_scene: Make) -> None:
    service = farm.start_service()
    no_worker = "No worker with a device is connected to the scheduler"
    wait_until(lambda: no_worker in service.http.get("/readyz").text, 30, farm.logs)
    assert service.http.get("/readyz").status_code == 503
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


@pytest.mark.slow
def test_a_configuration_is_checked_with_its_farm(farm: Farm, tmp_path: Path) -> None:
    """Whether the scheduler can be reached with these certificates, and what it has."""
    address = farm.environment["WOODCOCK_SCHEDULER"]

    def check(**environment: str) -> tuple[int, list[str]]:
        options = ("--check-config", "--port", "0", "--data", str(tmp_path / "data"))
        runner = CliRunner(env={**farm.environment, **environment})
        result = runner.invoke(service_app, options)
        return result.exit_code, result.output.splitlines()[2:]

    assert check() == (0, [f"The scheduler at {address} answers, but has no worker with a device."])
    farm.start_worker("node1")
    wait_until(lambda: "device offered" in farm.workers["node1"].log.read_text(), 90, farm.logs)
    status, (answers, device) = check()
    assert (status, answers) == (0, f"The scheduler at {address} answers.")
    assert re.fullmatch(r"Device cpu0@node1 is ready: .*, lanes 1.*\.", device)
    stranger = tmp_path / "stranger"
    certificate.write(stranger, certificate.VALID)
    status, (fault,) = check(WOODCOCK_CERTIFICATES=str(stranger))
    assert status == 2
    assert fault.startswith(f"The scheduler at {address} cannot be reached with these certificates: [SSL: ")
    farm.scheduler.stop()
    status, (fault,) = check()
    assert status == 2
    assert fault.startswith(f"The scheduler at {address} cannot be reached with these certificates: ")
    assert "Connection refused" in fault or "Timed out" in fault
