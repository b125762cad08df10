"""A farm on this machine: scheduler, workers and service as processes of their own that speak TLS."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from .harness import Farm, Part, wait_until

Make = Callable[..., dict[str, Any]]

WORKER = Path(__file__).parents[2] / "docker/kubernetes/base/worker.yaml"


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


def probe(kind: str, folder: Path) -> bool:
    """As Kubernetes asks a worker's pod whose temporary folder this is."""
    [container] = yaml.safe_load(WORKER.read_text())["spec"]["template"]["spec"]["containers"]
    *command, script = container[f"{kind}Probe"]["exec"]["command"]
    assert "/tmp/" in script
    done = subprocess.run([*command, script.replace("/tmp/", f"{folder}/")], capture_output=True)
    return done.returncode == 0


@pytest.mark.slow
def test_a_worker_gives_signs_of_life(farm: Farm, tmp_path: Path) -> None:
    folder = tmp_path / "temporary"
    folder.mkdir()

    def probes() -> tuple[bool, bool]:
        return probe("liveness", folder), probe("readiness", folder)

    def let_a_minute_pass() -> None:
        for sign in folder.glob("woodcock-*/*"):
            if sign.is_file():
                os.utime(sign, (time.time() - 61,) * 2)

    worker = farm.start_worker("node1", TMPDIR=str(folder))
    wait_until(lambda: probe("startup", folder), 60, farm.logs)
    wait_until(lambda: probes() == (True, True), 60, farm.logs)

    worker.process.send_signal(signal.SIGSTOP)
    let_a_minute_pass()
    assert probes() == (False, False), "it hangs"
    worker.process.send_signal(signal.SIGCONT)
    wait_until(lambda: probes() == (True, True), 30, farm.logs)

    farm.scheduler.stop()
    wait_until(lambda: "trying again" in worker.log.read_text(), 60, farm.logs)
    let_a_minute_pass()
    wait_until(lambda: probe("liveness", folder), 30, farm.logs)
    assert probes() == (True, False), "there is no scheduler"
    assert worker.stop() == 0
    assert list(folder.iterdir()) == []
