"""The files that server/farm.md tells users to copy, as they are, with what they are made for."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from tests.server.conftest import Service

from . import slurm as cluster
from . import ssh, systemd
from .harness import Farm, wait_until
from .slurm import Slurm
from .test_farm import ended

Make = Callable[..., dict[str, Any]]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]

RECIPES = Path(__file__).parents[2] / "server" / "recipes"


@pytest.fixture
def slurm() -> Iterator[Slurm]:
    if reason := cluster.fault():
        pytest.skip(f"SLURM cannot be had here: {reason}")
    with TemporaryDirectory(prefix="slurm-") as folder:
        made = Slurm(Path(folder))
        with made.made():
            yield made


def user(farm: Farm, folder: Path) -> dict[str, str]:
    """The environment of who has Woodcock's commands, and keeps temporary files in a folder."""
    folder.mkdir()
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return {**farm.environment, "PATH": path, "TMPDIR": str(folder), "WOODCOCK_PREPARE": "0"}


def rendered(service: Service, job_id: str, *devices: str) -> None:
    """To its end, by these devices, each sample counted once."""
    assert set(service.wait(job_id, ended, 300)["devices"]) == set(devices)
    report = service.http.get(f"/api/v1/jobs/{job_id}/report.json").json()
    assert report["samples"] == sum(stop - start for start, stop in report["sample_ranges"])
    assert report["samples"] == sum(use["samples"] for use in report["devices"])


def ssh_commands() -> list[str]:
    page = (RECIPES.parent / "farm.md").read_text()
    section = re.search(r"\n## SSH\n(.*?)\n## ", page, re.DOTALL)
    assert section
    return re.findall(r"```sh\n(.*?)```", section[1], re.DOTALL)


def test_slurm_runs_workers_until_their_time_is_up(farm: Farm, slurm: Slurm, make_scene: Make, tmp_path: Path) -> None:
    """Workers that are cancelled, or whose time is up, end cleanly; the next ones of the array take their places."""
    service = farm.start_service()
    scratch = tmp_path / "scratch"
    array = slurm.ask(
        "sbatch", "--parsable", "--array=1-9%2", "--time=1", str(RECIPES / "woodcock-worker.sbatch"),
        cwd=tmp_path, **user(farm, scratch),
    )  # fmt: skip

    def log(task: int) -> str:
        path = tmp_path / f"woodcock-worker-{array}_{task}.log"
        return path.read_text() if path.exists() else ""

    devices = "cpu0@node1", "cpu0@node2"
    farm.wait_for(service, *devices, seconds=120)
    job_id = service.submit(make_scene(stop={"kind": "seconds", "seconds": 150}))
    service.wait(job_id, lambda job: set(job["devices"]) == set(devices), 60)
    slurm.ask("scancel", f"{array}_1")
    # The second one's time is up a minute after its start, or a little later.
    for task in (3, 4):
        wait_until(lambda task=task: "device offered" in log(task), 200, slurm.logs)
    samples = service.job(job_id)["samples"]
    service.wait(job_id, lambda job: job["samples"] > samples, 60)
    rendered(service, job_id, *devices)
    slurm.ask("scancel", "--name=woodcock-worker")
    wait_until(slurm.empty, 60, slurm.logs)
    assert "CANCELLED AT" in log(1)
    assert "DUE TO TIME LIMIT" in log(2)
    assert not any("Traceback" in log(task) for task in range(1, 10))
    assert not list(scratch.iterdir())


def test_dask_jobqueue_asks_slurm_for_workers(farm: Farm, slurm: Slurm, make_scene: Make, tmp_path: Path) -> None:
    if find_spec("dask_jobqueue") is None:
        pytest.skip("dask-jobqueue is missing: pip install dask-jobqueue")
    service = farm.start_service()
    environment = {**os.environ, **slurm.environment, **user(farm, tmp_path / "scratch")}
    asked = {"DASK_JOBQUEUE__SLURM__CORES": "1", "DASK_JOBQUEUE__SLURM__MEMORY": "1GiB"}
    command = [sys.executable, str(RECIPES / "woodcock_jobqueue.py"), "2"]
    with subprocess.Popen(command, cwd=tmp_path, env={**environment, **asked}) as program:
        try:
            farm.wait_for(service, "cpu0@node1", "cpu0@node2", seconds=120)
            job_id = service.submit(make_scene(stop={"kind": "seconds", "seconds": 5}))
            rendered(service, job_id, "cpu0@node1", "cpu0@node2")
        finally:
            program.terminate()
    assert program.returncode == 0
    wait_until(slurm.empty, 60, slurm.logs)


def test_workers_are_started_and_stopped_by_ssh(farm: Farm, make_scene: Make, tmp_path: Path) -> None:
    """They outlive the connection, and leave nothing but their caches."""
    if reason := ssh.fault():
        pytest.skip(f"hosts with SSH cannot be had here: {reason}")
    start, stop, _ = ssh_commands()
    service = farm.start_service()
    farm.certificates.rename(tmp_path / "farm")
    settings = {name: os.environ[name] for name in ("PYTHONPATH",) if name in os.environ}
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    hosts = ssh.Hosts(
        tmp_path / "ssh",
        ("node1", "node2"),
        **settings,
        TMPDIR=str(scratch),
        POCL_DEVICES="pthread",
        WOODCOCK_PREPARE="0",
    )
    with hosts.made():
        for host in ("node1", "node2"):
            (hosts.home(host) / "woodcock").symlink_to(sys.prefix)

        def run(commands: str) -> None:
            commands = commands.replace("tls://HEAD:8786", farm.environment["WOODCOCK_SCHEDULER"])
            subprocess.run(["sh", "-ec", commands], cwd=tmp_path, env=hosts.environment, check=True, timeout=60)

        try:
            run(start)
            farm.wait_for(service, "cpu0@node1", "cpu0@node2", seconds=120)
            job_id = service.submit(make_scene(stop={"kind": "seconds", "seconds": 5}))
            rendered(service, job_id, "cpu0@node1", "cpu0@node2")
        finally:
            run(stop)
        farm.wait_for(service, seconds=60)
        for host in ("node1", "node2"):
            assert "Traceback" not in (hosts.home(host) / "worker.log").read_text()
        assert not list(scratch.iterdir())


def test_systemd_keeps_a_worker(farm: Farm, make_scene: Make, tmp_path: Path) -> None:
    """It is started again after it was killed, and ends cleanly when it is told to."""
    if reason := systemd.fault():
        pytest.skip(f"a machine with systemd cannot be had here: {reason}")
    service = farm.start_service()
    machine = systemd.Machine(tmp_path / "machine")
    with machine.made():
        settings = machine.root / "etc/woodcock"
        settings.mkdir(mode=0o700)
        shutil.copytree(farm.certificates, settings / "farm")
        own = {
            "WOODCOCK_SCHEDULER": farm.environment["WOODCOCK_SCHEDULER"], "WOODCOCK_WORKER_NAME": "node1",
            "WOODCOCK_PREPARE": "0", "POCL_DEVICES": "pthread", "PYTHONPATH": systemd.PYTHONPATH,
        }  # fmt: skip
        (settings / "worker.env").write_text("".join(f"{name}={value}\n" for name, value in own.items()))
        shutil.copy(RECIPES / "woodcock-worker.service", machine.root / "etc/systemd/system")
        machine.run("groupadd --force --system render; systemctl daemon-reload; systemctl enable --now woodcock-worker")

        def log() -> str:
            return machine.run("journalctl --unit=woodcock-worker --no-pager")

        farm.wait_for(service, "cpu0@node1", seconds=120)
        rendered(service, service.submit(make_scene()), "cpu0@node1")
        account = machine.run("ps -o uid= -p $(systemctl show --value --property=MainPID woodcock-worker)")
        assert int(account) != 0
        machine.run("systemctl kill --signal=KILL woodcock-worker")
        wait_until(lambda: log().count("device offered") == 2, 90, log)
        rendered(service, service.submit(make_scene()), "cpu0@node1")
        machine.run("systemctl stop woodcock-worker")
        assert machine.run("systemctl show --value --property=Result woodcock-worker") == "success\n"
        assert "Traceback" not in log()
