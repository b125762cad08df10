"""What is done while a stage is held. Each is a context: it has struck on entry, the stage is let go of inside, and at
the end it is over, or what died is started again."""

from __future__ import annotations

import random
import signal
import sqlite3
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from typing import Any, TypeAlias

import psutil
from tests.farm.harness import wait_until

from .rig import Rig, Target
from .rigs import Bucket, Clock, OnFarm

DAY = 86400

#: Takes a rig of the kind that it needs.
Strike: TypeAlias = Callable[[Any, Target], AbstractContextManager[None]]


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
    def strike(rig: Clock, _: Target) -> Iterator[None]:
        rig.jump(days * DAY)
        yield

    return strike


@contextmanager
def clock_back_and_worker_killed(rig: Clock, target: Target) -> Iterator[None]:
    with clock_jumped(-1)(rig, target), worker_killed(rig, target):
        yield


@contextmanager
def stopped(rig: Rig, target: Target) -> Iterator[None]:
    """For twice its lease; another service takes over."""
    process = stop_between_writes(rig, target)
    yield
    wait_until(lambda: rig.ended(target.job_id), 60)
    process.send_signal(signal.SIGCONT)
    time.sleep(1.5)  # for whatever it still does


def stop_between_writes(rig: Rig, target: Target) -> subprocess.Popen[str]:
    """Not in the middle of a transaction, for which others wait."""
    process = target.service.process
    assert process is not None
    process.send_signal(signal.SIGSTOP)
    while not rig.writable(target.job_id):
        process.send_signal(signal.SIGCONT)
        time.sleep(0.02)
        process.send_signal(signal.SIGSTOP)
    return process


def corrupted(spoil: Callable[[bytearray], None]) -> Strike:
    @contextmanager
    def strike(rig: Rig, target: Target) -> Iterator[None]:
        with service_killed(rig, target):
            films = [path for name, path in rig.files(target.job_id).items() if name.startswith("film-")]
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


# Across hosts


@contextmanager
def dispatcher_killed(rig: Rig, target: Target) -> Iterator[None]:
    """Another one takes over."""
    target.service.stop(signal.SIGKILL)
    yield
    wait_until(lambda: rig.ended(target.job_id), 60)
    target.service.start()


@contextmanager
def scheduler_killed(rig: OnFarm, _: Target) -> Iterator[None]:
    rig.farm.scheduler.stop(signal.SIGKILL)
    yield
    check_unready(rig)
    rig.farm.start_scheduler(rig.network.addresses["head"], port=8786)


@contextmanager
def cut_off_for_a_moment(rig: OnFarm, target: Target) -> Iterator[None]:
    """The host that is held, if one is."""
    rig.network.link(rig.host_of(target), up=False)
    yield
    rig.network.link(rig.host_of(target), up=True)


@contextmanager
def cut_off(rig: OnFarm, target: Target) -> Iterator[None]:
    """Until nobody counts on the host any more."""
    with cut_off_for_a_moment(rig, target):
        yield
        for service in rig.alive:
            rig.farm.wait_for(service, *rig.devices - {f"cpu0@{rig.host_of(target)}"})


@contextmanager
def cut_off_until_the_end(rig: OnFarm, target: Target) -> Iterator[None]:
    """Another host renders what it had."""
    with cut_off(rig, target):
        yield
        wait_until(lambda: rig.ended(target.job_id), 60)


@contextmanager
def store_killed(rig: Bucket, _: Target) -> Iterator[None]:
    rig.store.stop()
    yield
    check_unready(rig)
    rig.store.start()


@contextmanager
def store_hangs(rig: Bucket, _: Target) -> Iterator[None]:
    rig.store.hang()
    yield
    check_unready(rig)
    rig.store.go_on()


def check_unready(rig: Rig) -> None:
    """The services know of the fault."""
    for service in rig.alive:
        assert service.http.get("/readyz").status_code == 503
