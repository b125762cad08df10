"""Whether scheduler and worker hang, or have no scheduler, by the probes that Kubernetes is told to ask."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
import yaml

from .harness import Farm, Part, wait_until

MANIFESTS = Path(__file__).parents[2] / "docker/kubernetes/base"


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
