"""Rigs of every kind."""

from __future__ import annotations

import shutil
import struct
import subprocess
from contextlib import ExitStack
from datetime import timedelta
from pathlib import Path
from typing import ClassVar

import pytest
from tests.farm import network
from tests.farm.harness import on_hosts
from tests.server.conftest import Service
from tests.server.s3_server import S3Server

from woodcock_server import bucket
from woodcock_server.bucket import BucketStorage
from woodcock_server.store import connect

from .rig import Rig, Target
from .stages import PRELUDE


class Pair(Rig):
    """Two services with one data folder."""

    names = ("one", "other")


class SmallDisk(Rig):
    """The data folder is a disk of its own, and the folder of the jobs another mount."""

    def _surround(self, held: ExitStack) -> None:
        self._mount(held, self.data, "-t", "tmpfs", "-o", "size=32m", "tmpfs")
        (self.data / "jobs").mkdir()
        self._mount(held, self.data / "jobs", "--bind", str(self.data / "jobs"))

    def _mount(self, held: ExitStack, where: Path, *options: str) -> None:
        done = subprocess.run(["mount", *options, str(where)], capture_output=True, text=True)
        if done.returncode != 0:
            pytest.skip(f"cannot be tried here: {done.stderr.strip()}")
        held.callback(subprocess.run, ["umount", "--lazy", str(where)], check=True)


class Clock(Rig):
    """The service's clock can be set."""

    def _surround(self, held: ExitStack) -> None:
        if shutil.which("gcc") is None:
            pytest.skip("cannot be tried here: there is no gcc")
        library, self._clock = self.folder / "clock.so", self.folder / "clock"
        source = Path(__file__).with_name("clock.c")
        subprocess.run(["gcc", "-shared", "-fPIC", "-O2", "-o", str(library), str(source)], check=True)
        self._clock.write_bytes(bytes(8))
        self.environment |= {"LD_PRELOAD": str(library), "CHAOS_CLOCK": str(self._clock)}

    def jump(self, seconds: int) -> None:
        """Set it forward, or back."""
        with self._clock.open("r+b") as file:
            (before,) = struct.unpack("<q", file.read())
            file.seek(0)
            file.write(struct.pack("<q", before + seconds))


class Bucket(Rig):
    """Files are kept in an object store; each service has a folder of its own in the data folder."""

    def _surround(self, held: ExitStack) -> None:
        self.store = S3Server(self.folder / "s3")
        self.store.start()
        held.callback(self.store.stop)
        self.environment |= self.store.environment

    def _service(self, name: str) -> Service:
        return Service(self.data / name, PRELUDE, f"../log-{name}.txt", **self.environment, CHAOS_NAME=name)

    def files(self, job_id: str) -> dict[str, Path]:
        rows = self.rows("SELECT name, key FROM objects WHERE job_id = :id", id=job_id)
        return {row.name: self.store.path(row.key) for row in rows}

    def check_rest(self) -> None:
        """Every object is named by a row, but for what is collected once it is a day old."""
        self._collect()
        named = {row.key: row.size for row in self.rows("SELECT key, size FROM objects")}
        assert self.store.found() - {"probe"} == named.keys()
        assert {key: self.store.path(key).stat().st_size for key in named} == named
        assert not self.rows("SELECT key FROM objects WHERE job_id NOT IN (SELECT id FROM jobs)")
        for name in self.names:
            data = self.data / name
            assert {path.name for path in data.iterdir()} == {"copies", "scratch", "program.py"}
            assert {path.name for path in (data / "scratch").iterdir()} <= {"dask-scratch-space", "leaving"}
            assert not list((data / "scratch" / "leaving").glob("*/*"))
            assert {path.name for path in (data / "copies").glob(".*")} == {".lock"}

    def _collect(self) -> None:
        """As a service does it once a day, and as if one had passed."""
        with pytest.MonkeyPatch.context() as patch:
            for name, value in self.store.environment.items():
                patch.setenv(name, value)
            patch.setattr(bucket, "GRACE", timedelta(seconds=-60))
            store = connect(self.store.environment["WOODCOCK_STORE"])
            storage = BucketStorage(self.folder / "collecting", self.engine, store, 0)
            storage.collect()
            storage.close()


class OnFarm(Bucket):
    """Two services that share a scheduler, two worker hosts, a database and an object store."""

    names = ("one", "other")
    hosts: ClassVar[tuple[str, ...]] = ("node1", "node2")

    def _surround(self, held: ExitStack) -> None:
        if reason := network.fault():
            pytest.skip(f"cannot be tried here: {reason}")
        self.network = network.Network("head", *self.hosts)
        held.enter_context(self.network.made())
        held.enter_context(self.network.being("head"))
        super()._surround(held)
        self.farm = on_hosts(self.folder / "farm", self.network)
        held.callback(self.farm.close)
        for host in self.hosts:
            self.farm.start_worker(host, PRELUDE, CHAOS_GATES=str(self.gates.folder), CHAOS_NAME=host)
        self.environment |= self.farm.environment

    @property
    def devices(self) -> set[str]:
        return {f"cpu0@{host}" for host in self.hosts}

    def host_of(self, target: Target) -> str:
        """The one that is held; if none is, one that renders."""
        return target.held if target.held in self.hosts else self.hosts[0]

    def settle(self) -> None:
        for service in self.alive:
            self.farm.wait_for(service, *self.devices, seconds=90)

    @property
    def log(self) -> str:
        return f"{super().log}\n{self.farm.logs()}"


RIGS: dict[str, type[Rig]] = {
    "plain": Rig,
    "pair": Pair,
    "small disk": SmallDisk,
    "clock": Clock,
    "bucket": Bucket,
    "farm": OnFarm,
}
