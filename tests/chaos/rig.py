"""Services with a database and files that faults can be made in."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import psycopg
from psycopg import sql
from sqlalchemy import create_engine, make_url, text
from sqlalchemy.exc import OperationalError
from sqlalchemy.pool import NullPool
from tests.server.conftest import Service

from .stages import PRELUDE, Gates

LEASE = 1.0


@dataclass
class Target:
    """A job, the service that has it, and who is held: that service, or a worker host of a farm."""

    job_id: str
    service: Service
    held: str


class Rig:
    """One service on one machine; others are in rigs.py."""

    #: Of the services, which start in this order.
    names: ClassVar[tuple[str, ...]] = ("one",)

    def __init__(self, url: str | None, folder: Path) -> None:
        """url: of a PostgreSQL database; without it, there is one of SQLite in the data folder."""
        self.folder, self.data = folder, folder / "data"
        self.data.mkdir()
        self.postgresql = url is not None
        self.gates = Gates(folder / "gates")
        self.url = url or f"sqlite:///{self.data / 'woodcock.sqlite'}"
        self.engine = create_engine(
            make_url(self.url).set(drivername="postgresql+psycopg") if url else self.url, poolclass=NullPool
        )
        self.spoilt = False  # a fault was not survived
        self.environment = {
            "WOODCOCK_DATABASE_URL": self.url,
            "WOODCOCK_LEASE_SECONDS": str(LEASE),
            "CHAOS_GATES": str(self.gates.folder),
        }
        with ExitStack() as held:
            held.callback(self.engine.dispose)
            self._surround(held)
            self.services = {name: self._service(name) for name in self.names}
            for service in self.services.values():
                held.callback(_kill, service)
                service.start()
            self._held = held.pop_all()

    def _surround(self, held: ExitStack) -> None:
        """What the services need; held: gets what must end after them."""

    def _service(self, name: str) -> Service:
        return Service(self.data, PRELUDE, f"../log-{name}.txt", **self.environment, CHAOS_NAME=name)

    def close(self) -> None:
        self._held.close()

    def settle(self) -> None:
        """Wait until it is as before the last fault."""

    @property
    def log(self) -> str:
        return "\n".join(service.log.read_text()[-3000:] for service in self.services.values())

    @property
    def alive(self) -> list[Service]:
        return [service for service in self.services.values() if service.process and service.process.poll() is None]

    def target(self, job_id: str, held: str) -> Target:
        if held in self.services:
            return Target(job_id, self.services[held], held)
        pid = self.rows("SELECT holder FROM jobs WHERE id = :id", id=job_id)[0].holder.rpartition(":")[2]
        (service,) = (each for each in self.alive if each.process and each.process.pid == int(pid))
        return Target(job_id, service, held)

    # What faults do to the database

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
        with self.engine.connect() as connection:
            if not self.postgresql:
                connection.exec_driver_sql("PRAGMA busy_timeout=100")
            try:
                connection.execute(text(locking), {"id": job_id} if self.postgresql else {})
            except OperationalError:
                return False
            connection.rollback()
        return True

    def rows(self, query: str, **values: Any) -> list[Any]:
        with self.engine.connect() as connection:
            return list(connection.execute(text(query), values))

    def ended(self, job_id: str) -> bool:
        state: str = self.rows("SELECT state FROM jobs WHERE id = :id", id=job_id)[0].state
        return state in ("succeeded", "failed", "cancelled")

    def files(self, job_id: str) -> dict[str, Path]:
        """All that is kept of a job, by name, whether half-written or not."""
        return {path.name: path for path in (self.data / "jobs" / job_id).iterdir()}

    def check_rest(self) -> None:
        """Nothing is kept but the files of jobs that there are."""
        known = {row.id for row in self.rows("SELECT id FROM jobs")}
        assert {path.name for path in (self.data / "jobs").iterdir()} <= known
        assert not list((self.data / "volumes").iterdir())
        assert {path.name for path in (self.data / "scratch").iterdir()} <= {"dask-scratch-space"}
        own = {"jobs", "volumes", "scratch", "program.py"}
        own |= set() if self.postgresql else {f"woodcock.sqlite{suffix}" for suffix in ("", "-wal", "-shm")}
        assert {path.name for path in self.data.iterdir()} <= own


def _kill(service: Service) -> None:
    if service.process is not None:
        service.process.kill()
        service.process.communicate()
    if hasattr(service, "http"):
        service.http.close()
