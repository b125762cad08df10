"""The schema, and what SQLite is told."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import create_engine, text

from woodcock_server.database import alembic_config, open_database
from woodcock_server.jobs import repository as jobs
from woodcock_server.jobs.schemas import ANY
from woodcock_server.tables import metadata
from woodcock_server.volumes import repository


def test_the_migrations_lead_to_the_tables(tmp_path: Path) -> None:
    engine = open_database(f"sqlite:///{tmp_path / 'test.sqlite'}")
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, metadata) == []
        assert context.get_current_revision() == ScriptDirectory.from_config(alembic_config()).get_current_head()
    engine.dispose()


def test_what_was_uploaded_before_there_were_types_is_a_volume(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'test.sqlite'}"
    engine = create_engine(url)
    with engine.begin() as connection:
        config = alembic_config()
        config.attributes["connection"] = connection
        command.upgrade(config, "0001")
        row = "'sha256:1', '1', 'cloud.vdb', 5, '2030-01-02 03:04:05.000000', '[]'"
        connection.execute(text(f"INSERT INTO volumes (id, entry, name, size, created_at, grids) VALUES ({row})"))
    engine.dispose()
    engine = open_database(url)
    with engine.connect() as connection:
        kept = repository.get(connection, "sha256:1")
    assert kept is not None
    assert (kept["type"], kept["name"], kept["triangles"], kept["width"]) == ("volume", "cloud.vdb", None, None)
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, "0001")
    engine.dispose()


def test_a_job_of_before_devices_could_be_asked_for_asks_for_none(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'test.sqlite'}"
    engine = create_engine(url)
    with engine.begin() as connection:
        config = alembic_config()
        config.attributes["connection"] = connection
        command.upgrade(config, "0002")
        values = "'1', 'cube', '{}', 'queued', '2030-01-02 03:04:05.000000', 7, 0.5, '[]', '{}', 2"
        names = "id, name, scene, state, created_at, samples, seconds, series, usage, token"
        connection.execute(text(f"INSERT INTO jobs ({names}) VALUES ({values})"))
    engine.dispose()
    engine = open_database(url)
    now = datetime.now(UTC)
    with engine.begin() as connection:
        assert jobs.next_claimable(connection, now, ["cpu0"]) is None
        assert jobs.next_claimable(connection, now, [ANY]) == "1"
        row = jobs.claim(connection, "1", "a", now, timedelta(seconds=1))
    assert row is not None
    assert (row["device"], row["name"], row["samples"], row["token"]) == (ANY, "cube", 7, 3)
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, "0002")
        assert connection.scalar(text("SELECT name FROM jobs")) == "cube"
    engine.dispose()


def test_opening_again_changes_nothing(tmp_path: Path) -> None:
    for _ in range(2):
        engine = open_database(f"sqlite:///{tmp_path / 'test.sqlite'}")
        engine.dispose()


def test_sqlite_keeps_what_it_commits(tmp_path: Path) -> None:
    engine = open_database(f"sqlite:///{tmp_path / 'test.sqlite'}")
    with engine.connect() as connection:
        pragmas = {name: connection.scalar(text(f"PRAGMA {name}")) for name in ("journal_mode", "foreign_keys")}
        assert connection.scalar(text("PRAGMA synchronous")) == 2
    engine.dispose()
    assert pragmas == {"journal_mode": "wal", "foreign_keys": 1}
