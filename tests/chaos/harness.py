"""Services with a database and a data folder that faults can be made in, and what must hold of them afterwards."""

from __future__ import annotations

import json
import shutil
import struct
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
import psycopg
import pytest
from psycopg import sql
from sqlalchemy import create_engine, make_url, text
from sqlalchemy.exc import OperationalError
from sqlalchemy.pool import NullPool
from tests.server.conftest import Service
from tests.statistics import accept_z

from .stages import PIECE, PRELUDE, Gates

LEASE = 1.0
SAMPLES = 5 * PIECE
SIZE = 32

#: README, "The life of a job".
LEGAL = {
    None: {"queued"},
    "queued": {"running", "cancelled"},
    "running": {"running", "queued", "cancelling", "succeeded", "failed"},
    "cancelling": {"cancelled"},
}
FILES = {"image.exr", "preview.png", "thumbnail.webp", "report.json", "report.html"}


def wait_until(reached: Callable[[], Any], seconds: float) -> None:
    end = time.monotonic() + seconds
    while not reached():
        assert time.monotonic() < end, "it took too long"
        time.sleep(0.02)


def eventually(check: Callable[[], None], seconds: float) -> None:
    """The check passes within so many seconds."""
    end = time.monotonic() + seconds
    while True:
        try:
            return check()
        except AssertionError:
            if time.monotonic() > end:
                raise
        time.sleep(0.1)


@dataclass
class Target:
    """A job and the service that has it."""

    job_id: str
    service: Service


class Rig:
    """kind: plain; pair: of two services; small disk: the data folder is one of its own; clock: theirs can be set."""

    def __init__(self, kind: str, url: str | None, folder: Path) -> None:
        self.kind, self.folder, self.data = kind, folder, folder / "data"
        self.postgresql = url is not None
        self.gates = Gates(folder / "gates")
        self.url = url or f"sqlite:///{self.data / 'woodcock.sqlite'}"
        self._engine = create_engine(
            make_url(self.url).set(drivername="postgresql+psycopg") if url else self.url, poolclass=NullPool
        )
        self.spoilt = False  # a fault was not survived
        self._clock = folder / "clock"
        self._mounts: list[Path] = []
        environment = {
            "WOODCOCK_DATABASE_URL": self.url,
            "WOODCOCK_LEASE_SECONDS": str(LEASE),
            "CHAOS_GATES": str(self.gates.folder),
        }
        if kind == "clock":
            library = folder / "clock.so"
            command = ["gcc", "-shared", "-fPIC", "-O2", "-o", str(library), str(Path(__file__).with_name("clock.c"))]
            if shutil.which("gcc") is None:
                pytest.skip("cannot be tried here: there is no gcc")
            subprocess.run(command, check=True)
            self._clock.write_bytes(bytes(8))
            environment |= {"LD_PRELOAD": str(library), "CHAOS_CLOCK": str(self._clock)}
        names = ["one", "other"] if kind == "pair" else ["one"]
        self.services = {
            name: Service(self.data, PRELUDE, f"../log-{name}.txt", **environment, CHAOS_NAME=name) for name in names
        }
        self.data.mkdir()
        try:
            if kind == "small disk":
                self._mount(self.data, "-t", "tmpfs", "-o", "size=32m", "tmpfs")
                (self.data / "jobs").mkdir()
                self._mount(self.data / "jobs", "--bind", str(self.data / "jobs"))
            for service in self.services.values():
                service.start()
        except BaseException:
            self.close()
            raise

    def _mount(self, where: Path, *options: str) -> None:
        done = subprocess.run(["mount", *options, str(where)], capture_output=True, text=True)
        if done.returncode != 0:
            pytest.skip(f"cannot be tried here: {done.stderr.strip()}")
        self._mounts.append(where)

    def close(self) -> None:
        for service in self.services.values():
            if service.process is not None:
                service.process.kill()
                service.process.communicate()
            if hasattr(service, "http"):
                service.http.close()
        for where in reversed(self._mounts):
            subprocess.run(["umount", "--lazy", str(where)], check=True)
        self._engine.dispose()

    @property
    def log(self) -> str:
        return "\n".join(service.log.read_text()[-3000:] for service in self.services.values())

    @property
    def alive(self) -> list[Service]:
        return [service for service in self.services.values() if service.process and service.process.poll() is None]

    # What faults do

    def jump(self, seconds: int) -> None:
        """Set the services' clocks forward, or back."""
        with self._clock.open("r+b") as file:
            (before,) = struct.unpack("<q", file.read())
            file.seek(0)
            file.write(struct.pack("<q", before + seconds))

    @contextmanager
    def _administrator(self) -> Iterator[tuple[psycopg.Connection[Any], str]]:
        """A connection to the server, not to the service's database; and that one's name."""
        url = make_url(self.url)
        assert url.database
        with psycopg.connect(
            url.set(database="postgres").render_as_string(hide_password=False), autocommit=True
        ) as connection:
            yield connection, url.database

    def cut_connections(self) -> None:
        with self._administrator() as (connection, name):
            connection.execute(
                "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = %s AND pid <> pg_backend_pid()",
                (name,),
            )

    @contextmanager
    def refusing(self) -> Iterator[None]:
        """The database lets nobody in, and has thrown out who was."""

        def let_in(allowed: bool) -> None:
            with self._administrator() as (connection, name):
                words = sql.SQL("ALTER DATABASE {} ALLOW_CONNECTIONS {}")
                connection.execute(words.format(sql.Identifier(name), sql.Literal(allowed)))

        let_in(False)
        try:
            self.cut_connections()
            yield
        finally:
            let_in(True)

    # What there is

    def writable(self, job_id: str) -> bool:
        """Nobody is in the middle of writing the job's row."""
        locking = "SELECT id FROM jobs WHERE id = :id FOR UPDATE NOWAIT" if self.postgresql else "BEGIN IMMEDIATE"
        with self._engine.connect() as connection:
            if not self.postgresql:
                connection.exec_driver_sql("PRAGMA busy_timeout=100")
            try:
                connection.execute(text(locking), {"id": job_id} if self.postgresql else {})
            except OperationalError:
                return False
            connection.rollback()
        return True

    def rows(self, query: str, **values: Any) -> list[Any]:
        with self._engine.connect() as connection:
            return list(connection.execute(text(query), values))

    def ended(self, job_id: str) -> bool:
        state: str = self.rows("SELECT state FROM jobs WHERE id = :id", id=job_id)[0].state
        return state in ("succeeded", "failed", "cancelled")


@dataclass(frozen=True)
class Picture:
    layers: dict[str, np.ndarray]
    header: dict[str, str]
    preview: bytes


def picture(rig: Rig, job_id: str) -> Picture:
    """What lies in the job's folder, read without the renderer's code."""
    folder = rig.data / "jobs" / job_id
    buffer = oiio.ImageBuf(str(folder / "image.exr"))
    pixels, spec = np.asarray(buffer.get_pixels(oiio.FLOAT)), buffer.spec()
    layers = {name: pixels[..., index] for index, name in enumerate(spec.channelnames)}
    header = {each.name: str(each.value) for each in spec.extra_attribs}
    return Picture(layers, header, (folder / "preview.png").read_bytes())


def check_states(rig: Rig, job_id: str) -> list[str]:
    """A legal walk from the queue to the end that the row has; returns it."""
    row = rig.rows("SELECT state, error, holder, lease_until FROM jobs WHERE id = :id", id=job_id)[0]
    assert (row.state, row.error, row.holder, row.lease_until) == ("succeeded", None, None, None)
    events = rig.rows("SELECT state FROM job_events WHERE job_id = :id ORDER BY id", id=job_id)
    walk = [event.state for event in events]
    for before, after in pairwise([None, *walk]):
        assert after in LEGAL.get(before, ()), walk
    assert walk[-1] == "succeeded"
    return walk


def check_picture(rig: Rig, job_id: str, undisturbed: Picture, alone: bool) -> None:
    """Every sample counts once. alone: one device rendered it, so every bit is that of the picture without a fault."""
    found = picture(rig, job_id)
    assert json.loads(found.header["woodcock:sampleRanges"]) == [[0, SAMPLES]]
    assert (found.layers["samples.count"] == SAMPLES).all()
    assert found.layers.keys() == undisturbed.layers.keys()
    if alone:
        for name, layer in found.layers.items():
            assert np.array_equal(layer, undisturbed.layers[name]), name
        assert found.preview == undisturbed.preview, "the preview is that of the picture"
    else:
        same, other = found.layers["Y"].astype(float), undisturbed.layers["Y"].astype(float)
        variance = found.layers["variance.Y"].astype(float).sum() + undisturbed.layers["variance.Y"].astype(float).sum()
        accept_z((same - other).sum() / np.sqrt(variance), exact=False)
    report = json.loads((rig.data / "jobs" / job_id / "report.json").read_text())
    assert (report["samples"], report["sample_ranges"]) == (SAMPLES, [[0, SAMPLES]])
    assert sum(use["samples"] for use in report["devices"]) == SAMPLES
    for before, after in pairwise(report["error"]):
        assert before["samples"] < after["samples"]


def check_files(rig: Rig, job_id: str) -> None:
    """No file that nothing knows, and none half-written."""
    token = rig.rows("SELECT token FROM jobs WHERE id = :id", id=job_id)[0].token
    films = {path.name for path in (rig.data / "jobs" / job_id).glob("film-*.npz")}
    assert len(films) == 1
    assert int(next(iter(films)).removeprefix("film-").removesuffix(".npz")) <= token
    assert {path.name for path in (rig.data / "jobs" / job_id).iterdir()} == FILES | films
    known = {row.id for row in rig.rows("SELECT id FROM jobs")}
    assert {path.name for path in (rig.data / "jobs").iterdir()} <= known
    assert not list((rig.data / "volumes").iterdir())
    assert {path.name for path in (rig.data / "scratch").iterdir()} <= {"dask-scratch-space"}
    own = {"jobs", "volumes", "scratch", "program.py"}
    own |= set() if rig.postgresql else {f"woodcock.sqlite{suffix}" for suffix in ("", "-wal", "-shm")}
    assert {path.name for path in rig.data.iterdir()} <= own


def check_answers(rig: Rig, job_id: str, body: dict[str, Any], key: str, walk: list[str]) -> None:
    """A request that comes twice is done once, and the events are told, by every service."""
    for service in rig.alive:
        before = rig.rows("SELECT count(*) AS jobs FROM jobs")
        again = service.http.post("/api/v1/jobs", json=body, headers={"Idempotency-Key": key})
        assert (again.status_code, again.json()["id"]) == (201, job_id)
        assert rig.rows("SELECT count(*) AS jobs FROM jobs") == before
        told, event = [], ""
        with service.http.stream("GET", f"/api/v1/jobs/{job_id}/events") as stream:
            for line in stream.iter_lines():
                if line.startswith("event: "):
                    event = line.removeprefix("event: ")
                elif line.startswith("data: ") and event == "state":
                    told.append(json.loads(line.removeprefix("data: "))["state"])
        assert (told, event) == (walk, "end")
        wait_until(lambda service=service: service.http.get("/readyz").status_code == 200, 10)
