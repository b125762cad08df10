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

MANIFESTS = Path(__file__).parents[2] / "docker/kubernetes/base"


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


def probes(manifest: str, folder: Path) -> tuple[bool, bool]:
    """What Kubernetes would find whose pod has this temporary folder: is it alive, and ready?"""
    pod = next(yaml.safe_load_all((MANIFESTS / manifest).read_text()))["spec"]["template"]["spec"]
    [container] = pod["containers"]

    def probe(kind: str) -> bool:
        *command, script = container[f"{kind}Probe"]["exec"]["command"]
        assert "/tmp/" in script
        done = subprocess.run([*command, script.replace("/tmp/", f"{folder}/")], capture_output=True)
        return done.returncode == 0

    return probe("liveness"), probe("readiness")


def let_a_minute_pass(folder: Path) -> None:
    for sign in folder.glob("woodcock-*/*"):
        if sign.is_file():
            os.utime(sign, (time.time() - 61,) * 2)


@pytest.mark.slow
@pytest.mark.parametrize("command", ["scheduler", "worker"])
def test_who_hangs_gives_no_signs_of_life(farm: Farm, tmp_path: Path, command: str) -> None:
    folder, options = tmp_path / "temporary", ("--port", "0") if command == "scheduler" else ()
    folder.mkdir()
    manifest = f"{command}.yaml"
    part = Part(tmp_path / "part", command, *options, TMPDIR=str(folder), **farm.environment)
    try:
        wait_until(lambda: probes(manifest, folder) == (True, True), 120, farm.logs)
        part.process.send_signal(signal.SIGSTOP)
        let_a_minute_pass(folder)
        assert probes(manifest, folder) == (False, False)
        part.process.send_signal(signal.SIGCONT)
        wait_until(lambda: probes(manifest, folder) == (True, True), 60, farm.logs)
    finally:
        assert part.stop() == 0
    assert list(folder.glob("woodcock-*")) == []


@pytest.mark.slow
def test_a_worker_without_a_scheduler_lives_and_is_not_ready(farm: Farm, tmp_path: Path) -> None:
    folder = tmp_path / "temporary"
    folder.mkdir()
    worker = farm.start_worker("node1", TMPDIR=str(folder))
    wait_until(lambda: probes("worker.yaml", folder) == (True, True), 120, farm.logs)
    farm.scheduler.stop()
    wait_until(lambda: "trying again" in worker.log.read_text(), 60, farm.logs)
    let_a_minute_pass(folder)
    wait_until(lambda: probes("worker.yaml", folder) == (True, False), 60, farm.logs)
    assert worker.stop() == 0
