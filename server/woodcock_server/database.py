"""The database: engine, connection settings, schema at its head. The only place that knows SQLite from PostgreSQL.

A transaction either reads or begins with its write: SQLite refuses a reader that turns writer after another's write.
"""

from __future__ import annotations

import threading
from importlib.resources import files
from typing import Any, NamedTuple

from alembic import command
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url, text
from sqlalchemy.exc import ArgumentError

#: By which servers that start together on one PostgreSQL wait for each other; any number that nothing else there uses.
MIGRATING = 0x0D0C0C
#: That answer requests, as many as AnyIO has.
THREADS = 40
#: How long a write waits for others.
BUSY_SECONDS = 10
#: Of a connection whose turn it is to write.
WRITING = "writing"


def open_database(url: str) -> Engine:
    """An engine whose schema is up to date. Raises sqlalchemy.exc.SQLAlchemyError."""
    engine = connect(url)
    # Servers that start together must not migrate together: a lock first, SQLite's own for writing or one by number.
    with engine.execution_options(immediate=True).begin() as connection:
        if engine.dialect.name == "postgresql":
            connection.execute(text(f"SELECT pg_advisory_xact_lock({MIGRATING})"))
        revision(connection)
        config = alembic_config()
        config.attributes["connection"] = connection
        command.upgrade(config, "head")
    return engine


def connect(url: str) -> Engine:
    """An engine for the database as it is. Raises sqlalchemy.exc.SQLAlchemyError."""
    named = _with_driver(url)
    try:
        # Errors go into the log: they must not tell what was to be written, secrets among it. As many connections stay
        # as there are threads that answer requests.
        engine = create_engine(named, pool_pre_ping=True, hide_parameters=True, pool_size=THREADS)
    except ImportError as error:
        driver = "pip install 'woodcock[postgres]'" if named.drivername == "postgresql+psycopg" else str(error)
        raise ArgumentError(f"its driver is not installed: {driver}") from None
    if engine.dialect.name == "sqlite":
        event.listen(engine, "connect", _configure_sqlite)
        event.listen(engine, "begin", _begin_sqlite)
        _take_turns(engine)
    return engine


class Revision(NamedTuple):
    """found: of the database, None for an empty one; head: of this version."""

    found: str | None
    head: str | None

    @property
    def current(self) -> bool:
        return self.found == self.head


def revision(connection: Connection) -> Revision:
    """Of the schema. Raises sqlalchemy.exc.ArgumentError for one of a newer version of this program."""
    scripts = ScriptDirectory.from_config(alembic_config())
    found = MigrationContext.configure(connection).get_current_revision()
    if found is not None and found not in {script.revision for script in scripts.walk_revisions()}:
        raise ArgumentError(f"it is of a newer version of Woodcock, whose revision {found} this one does not know")
    return Revision(found, scripts.get_current_head())


def _with_driver(url: str) -> URL:
    """`postgresql://…` is what everybody writes; SQLAlchemy would take it for a driver that is not this project's."""
    named = make_url(url)
    return named.set(drivername="postgresql+psycopg") if named.drivername == "postgresql" else named


def alembic_config() -> Config:
    """Alembic's configuration, with the migrations of the installed package."""
    config = Config()
    config.set_main_option("script_location", str(files("woodcock_server") / "migrations"))
    config.set_main_option("path_separator", "os")
    return config


def _configure_sqlite(connection: Any, _record: Any) -> None:
    # The driver would begin transactions by itself, and not for every statement; _begin_sqlite does.
    connection.isolation_level = None
    for pragma in ("journal_mode=WAL", "synchronous=FULL", "foreign_keys=ON", f"busy_timeout={1000 * BUSY_SECONDS}"):
        connection.execute(f"PRAGMA {pragma}")


def _take_turns(engine: Engine) -> None:
    """Let one thread write at a time. SQLite sees to that, but who finds it locked sleeps for a while and looks again,
    so that in a crowd some wait for seconds; here the next one begins as soon as the last one has ended."""
    turn = threading.Lock()

    def before(connection: Connection, _cursor: Any, statement: str, *_: Any) -> None:
        if not connection.info.get(WRITING) and statement.lstrip()[:6].upper() in ("INSERT", "UPDATE", "DELETE"):
            # One that stays away is another process's affair, or a fault that SQLite tells of itself.
            connection.info[WRITING] = turn.acquire(timeout=BUSY_SECONDS)

    def after(_connection: Any, record: Any) -> None:
        if record.info.pop(WRITING, False):
            turn.release()

    event.listen(engine, "before_cursor_execute", before)
    event.listen(engine.pool, "checkin", after)


def _begin_sqlite(connection: Connection) -> None:
    immediate = connection.get_execution_options().get("immediate", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if immediate else "BEGIN")
