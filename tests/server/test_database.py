"""The schema, and what SQLite is told."""

from __future__ import annotations

import json
import sys
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Engine, MetaData, create_engine, inspect, text
from sqlalchemy.exc import ArgumentError

from woodcock_server.database import alembic_config, open_database
from woodcock_server.devices.choice import ANY
from woodcock_server.jobs import repository as jobs
from woodcock_server.tables import metadata
from woodcock_server.volumes import repository

NOW = datetime(2030, 1, 2, 3, 4, 5, tzinfo=UTC)
THEN = "2030-01-02 03:04:05.000000+00:00"
JOB, VOLUME = "0190aaaa-0000-7000-8000-000000000001", "0190aaaa-0000-7000-8000-000000000002"

USAGE = json.dumps({"cpu0": {"kinds": {"integrator": ["transmittance"]}}})
#: Of every table a row, by the columns that it has had at any time; each revision gets those that it knows.
ROWS: dict[str, dict[str, Any]] = {
    "jobs": {
        "id": JOB, "name": "cube", "scene": "{\"film\": {\"width\": 4, \"height\": 4}}", "state": "succeeded",
        "created_at": THEN, "started_at": THEN, "finished_at": THEN, "samples": 7, "seconds": 0.5, "series": "[]",
        "usage": USAGE, "token": 2, "device": ANY, "spent": "{}", "priority": 3,
        "batch": VOLUME, "point": "{\"seed\": 1}", "integrator": "transmittance", "comparison": VOLUME, "owner": "ann",
    },
    "batches": {
        "id": VOLUME, "name": "", "scene": "{}", "product": "{\"seed\": [1]}", "zip": "{}", "created_at": THEN,
    },
    "volumes": {
        "id": "sha256:1", "entry": VOLUME, "name": "cloud.vdb", "size": 5, "created_at": THEN, "grids": "[]",
        "type": "volume",
    },
    "stability_checks": {
        "id": VOLUME, "fingerprint": "f", "identity": "a device", "version": "0.1.0", "passed": True,
        "started_at": THEN, "finished_at": THEN, "rows": "[]",
    },
    "comparisons": {
        "id": VOLUME, "name": "two", "scene": "{}", "vary": "{}", "seconds": 2.0, "device": ANY, "created_at": THEN,
        "variants": "[]",
    },
    "job_tags": {"job_id": JOB, "tag": "fog"},
    "job_devices": {"job_id": JOB, "device": "cpu0"},
    "answers": {"key": "k", "digest": "d", "answer": "{}", "created_at": THEN},
    "tokens": {"id": VOLUME, "name": "farm", "digest": "d", "scope": "write", "created_at": THEN},
    "job_files": {"job_id": JOB, "file": "sha256:1"},
    "webhooks": {
        "job_id": JOB, "url": "https://a.example", "secret": "whsec_x", "state": "delivered", "attempts": 1,
    },
    "job_events": {"job_id": JOB, "state": "succeeded", "at": THEN},
    "objects": {"job_id": JOB, "name": "image.exr", "key": "jobs/1/2/image.exr", "size": 9},
}  # fmt: skip
REVISIONS = [script.revision for script in ScriptDirectory.from_config(alembic_config()).walk_revisions()][::-1]


def at_revision(database: str, revision: str) -> Engine:
    """A database as a version of before left it, with a row in each of its tables."""
    engine = open_database(database)  # and back again, which tries the ways down
    config = alembic_config()
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, revision)
        tables = MetaData()
        tables.reflect(connection)
        for table in tables.sorted_tables:
            if table.name in ROWS:
                columns = {name: value for name, value in ROWS[table.name].items() if name in table.c}
                names, marks = ", ".join(f'"{name}"' for name in columns), ", ".join(f":{name}" for name in columns)
                connection.execute(text(f"INSERT INTO {table.name} ({names}) VALUES ({marks})"), columns)
        assert {*tables.tables} - {*ROWS} == {"alembic_version"}, "every table has a row here"
    return engine


@pytest.mark.parametrize("revision", REVISIONS)
def test_what_any_version_left_is_there_after_all_migrations(database: str, revision: str) -> None:
    engine = at_revision(database, revision)
    with engine.connect() as connection:
        before = {
            table: list(connection.execute(text(f"SELECT * FROM {table}")).mappings())
            for table in ROWS
            if inspect(connection).has_table(table)
        }
    engine.dispose()
    engine = open_database(database)
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, metadata) == []
        for table, rows in before.items():
            after = list(connection.execute(text(f"SELECT * FROM {table}")).mappings())
            same = ({*rows[0]} & {*after[0]}) - {"owner"}  # once of a job the name of who holds it
            assert [{name: row[name] for name in same} for row in after] == [
                {name: row[name] for name in same} for row in rows
            ]
        job = jobs.get(connection, JOB)
        assert job is not None
        assert (job["name"], job["state"], job["samples"], job["created_at"]) == ("cube", "succeeded", 7, NOW)
        assert [event["state"] for event in jobs.events(connection, JOB, 0)] == ["succeeded"]
        assert (job["devices"], job["integrator"]) == (["cpu0"], "transmittance")
    engine.dispose()


def test_servers_that_start_together_migrate_once(database: str) -> None:
    with ThreadPoolExecutor(4) as pool:
        engines = list(pool.map(open_database, [database] * 4))
    for engine in engines:
        with engine.connect() as connection:
            assert MigrationContext.configure(connection).get_current_revision() == REVISIONS[-1]
        engine.dispose()


def test_a_database_without_its_driver_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "psycopg", None)
    with pytest.raises(ArgumentError, match=r"pip install 'woodcock\[postgres\]'"):
        open_database("postgresql://nobody@127.0.0.1:9/nothing")


def test_the_migrations_lead_to_the_tables(database: str) -> None:
    engine = open_database(database)
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, metadata) == []
        assert context.get_current_revision() == ScriptDirectory.from_config(alembic_config()).get_current_head()
    engine.dispose()


def test_sweeps_are_owned_by_whom_their_jobs_are(database: str) -> None:
    at_revision(database, "0015").dispose()
    engine = open_database(database)
    with engine.connect() as connection:
        owners = connection.execute(text("SELECT owner FROM batches UNION ALL SELECT owner FROM comparisons"))
        assert list(owners.scalars()) == ["ann", "ann"]
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
