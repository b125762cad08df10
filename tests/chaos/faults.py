"""What goes wrong while a stage is held. Each is a context: it has struck on entry, the stage is let go of inside, and
at the end it is over, or what died is started again."""

from __future__ import annotations

import random
import signal
import sqlite3
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field

import psutil

from .harness import LEASE, Rig, Target, wait_until
from .stages import STAGES, WITH_CHECKPOINT

DAY = 86400

Strike = Callable[[Rig, Target], AbstractContextManager[None]]


@dataclass(frozen=True)
class Fault:
    """rig: the kind that it needs; device: that the job asks for; lasts: seconds that it goes on after the stage was
    let go of; senseless: stage or database -> why the two do not go together."""

    name: str
    strike: Strike
    rig: str = "plain"
    device: str = "cpu0"
    lasts: float = 0.0
    senseless: dict[str, str] = field(default_factory=dict)


@contextmanager
def service_killed(rig: Rig, target: Target) -> Iterator[None]:
    left = target.service.workers()
    assert left
    target.service.stop(signal.SIGKILL)
    _, alive = psutil.wait_procs(left, timeout=15)
    assert not alive, "workers end with their service"
    yield
    target.service.start()


@contextmanager
def dispatcher_cancelled(rig: Rig, _: Target) -> Iterator[None]:
    rig.gates.ask("cancel")
    wait_until(lambda: not (rig.gates.folder / "cancel").exists(), 5)
    yield


@contextmanager
def dispatcher_raises(rig: Rig, _: Target) -> Iterator[None]:
    rig.gates.ask("raise")
    yield  # at the claim, its lease is not renewed before the stage is let go of
    with suppress(FileNotFoundError):  # the job may have been faster
        (rig.gates.folder / "raise").unlink()


@contextmanager
def worker_killed(rig: Rig, target: Target) -> Iterator[None]:
    for worker in target.service.workers():
        worker.kill()
    yield


@contextmanager
def connections_cut(rig: Rig, _: Target) -> Iterator[None]:
    rig.cut_connections()
    yield


@contextmanager
def database_away(rig: Rig, _: Target) -> Iterator[None]:
    """It refuses connections; SQLite's file is locked by another program."""
    if rig.postgresql:
        with rig.refusing():
            yield
    else:
        with sqlite3.connect(rig.data / "woodcock.sqlite", timeout=10, isolation_level=None) as connection:
            connection.execute("BEGIN EXCLUSIVE")
            yield
            connection.execute("ROLLBACK")
        connection.close()


@contextmanager
def disk_full(rig: Rig, _: Target) -> Iterator[None]:
    ballast = rig.data / "ballast"
    with ballast.open("wb", buffering=0) as file:
        for size in (1 << 20, 1 << 12, 1):
            with suppress(OSError):
                while True:
                    file.write(bytes(size))
    yield
    ballast.unlink()


@contextmanager
def disk_read_only(rig: Rig, _: Target) -> Iterator[None]:
    remount(rig, "ro")
    yield
    remount(rig, "rw")


def remount(rig: Rig, how: str) -> None:
    """The folder of the jobs, in which nothing is open for longer than a moment: a mount in use cannot be changed."""

    def done() -> bool:
        command = ["mount", "-o", f"remount,bind,{how}", str(rig.data / "jobs")]
        return subprocess.run(command, capture_output=True).returncode == 0

    wait_until(done, 5)


def clock_jumped(days: int) -> Strike:
    @contextmanager
    def strike(rig: Rig, _: Target) -> Iterator[None]:
        rig.jump(days * DAY)
        yield

    return strike


@contextmanager
def clock_back_and_worker_killed(rig: Rig, target: Target) -> Iterator[None]:
    with clock_jumped(-1)(rig, target), worker_killed(rig, target):
        yield


@contextmanager
def stopped(rig: Rig, target: Target) -> Iterator[None]:
    """For twice its lease; another service takes over. Not in the middle of a transaction, for which others wait."""
    process = target.service.process
    assert process is not None
    process.send_signal(signal.SIGSTOP)
    while not rig.writable(target.job_id):
        process.send_signal(signal.SIGCONT)
        time.sleep(0.02)
        process.send_signal(signal.SIGSTOP)
    yield
    wait_until(lambda: rig.ended(target.job_id), 60)
    process.send_signal(signal.SIGCONT)
    time.sleep(1.5)  # for whatever it still does


def corrupted(spoil: Callable[[bytearray], None]) -> Strike:
    @contextmanager
    def strike(rig: Rig, target: Target) -> Iterator[None]:
        with service_killed(rig, target):
            films = list((rig.data / "jobs" / target.job_id).glob("film-*.npz"))
            assert films, "there is a checkpoint"
            for film in films:
                content = bytearray(film.read_bytes())
                spoil(content)
                film.write_bytes(content)
            yield

    return strike


def truncate(content: bytearray) -> None:
    del content[len(content) // 2 :]


def flip(content: bytearray) -> None:
    """One bit in each KiB."""
    chosen = random.Random(1)
    for start in range(0, len(content), 1024):
        where = min(len(content) - 1, start + chosen.randrange(1024))
        content[where] ^= 1 << chosen.randrange(8)


NO_FILM = dict.fromkeys(
    (stage for stage in STAGES if stage not in WITH_CHECKPOINT), "no checkpoint is there, or none is read any more"
)
GONE_BY = {"ended": "the lease is renewed no more", "claim": "the lease is not renewed yet"}

FAULTS = [
    Fault("service killed", service_killed),
    Fault("dispatcher cancelled", dispatcher_cancelled),
    Fault("dispatcher raises", dispatcher_raises, lasts=LEASE, senseless=GONE_BY),
    Fault("worker killed", worker_killed),
    Fault("worker killed, two devices", worker_killed, device="any"),
    Fault("connections cut", connections_cut, senseless={"sqlite": "a file has no connections"}),
    Fault("database away", database_away, lasts=2.5 * LEASE),
    Fault("disk full", disk_full, rig="small disk", lasts=2.5 * LEASE),
    Fault("disk read-only", disk_read_only, rig="small disk", lasts=2.5 * LEASE),
    Fault("clock +1 day", clock_jumped(1), rig="clock"),
    Fault("clock -1 day", clock_jumped(-1), rig="clock"),
    Fault("clock -1 day, worker killed", clock_back_and_worker_killed, rig="clock"),
    Fault("stopped for two leases", stopped, rig="pair", lasts=2 * LEASE),
    Fault("checkpoint truncated", corrupted(truncate), senseless=NO_FILM),
    Fault("checkpoint's bits flipped", corrupted(flip), senseless=NO_FILM),
]
