"""What is deleted when: by age and by room, never what is pinned or needed."""

from __future__ import annotations

import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Engine, select, update
from starlette.testclient import TestClient

from woodcock_server import app as application
from woodcock_server.config import Settings
from woodcock_server.database import open_database
from woodcock_server.devices.choice import ANY
from woodcock_server.jobs import repository
from woodcock_server.retention.due import Rule, due
from woodcock_server.retention.sweeper import sweep
from woodcock_server.storage import Storage
from woodcock_server.tables import jobs, volumes
from woodcock_server.volumes import repository as files

from .conftest import ADDRESS

NOW = datetime.now(UTC)
Make = Callable[..., dict[str, Any]]
FOREVER = Rule(None, None)


class House:
    """A database and a data folder with renders and uploads made by hand."""

    def __init__(self, engine: Engine, storage: Storage, scene: dict[str, Any]) -> None:
        """scene: of every render, but for the file that it names."""
        self.engine, self.storage, self.scene = engine, storage, scene

    def file(self, letter: str, days: float = 5) -> str:
        """An upload of 50 bytes, made so many days ago."""
        volume_id = f"sha256:{letter * 64}"
        columns = {"name": letter, "owner": "", "size": 50, "type": "volume", "grids": []}
        with self.engine.begin() as connection:
            files.add(connection, volume_id, columns)
            connection.execute(update(volumes).where(volumes.c.id == volume_id).values(used_at=ago(days)))
        self.storage.volume_file(volume_id).write_bytes(bytes(50))
        return volume_id

    def job(self, days: float, file: str | None = None, **columns: Any) -> str:
        """A render that ended so many days ago, with 100 bytes of files."""
        scene = {**self.scene, "volumes": [{"kind": "grid", "file": file, "albedo": 0.5}] if file else []}
        ended = {"state": "succeeded", "finished_at": ago(days), **columns}
        with self.engine.begin() as connection:
            job_id = repository.add(connection, {"name": "", "scene": scene, "device": ANY}, ago(days + 1))
            connection.execute(update(jobs).where(jobs.c.id == job_id).values(**ended))
        self.storage.open_job(job_id)
        self.storage.job_file(job_id, "image.exr").write_bytes(bytes(100))
        return job_id

    def sweep(self, days: float | None = None, size: int | None = None) -> None:
        """And what is left must be whole: rows with folders, folders with rows."""
        sweep(self.engine, self.storage, Rule(days, size), NOW)
        assert self.storage.folders() == set(self.jobs)
        assert {f"sha256:{path.name}" for path in self.storage.volumes.iterdir()} == set(self.files)

    @property
    def jobs(self) -> list[str]:
        with self.engine.connect() as connection:
            return list(connection.execute(select(jobs.c.id).order_by(jobs.c.finished_at)).scalars())

    @property
    def files(self) -> list[str]:
        with self.engine.connect() as connection:
            return list(connection.execute(select(volumes.c.id).order_by(volumes.c.id)).scalars())


def ago(days: float) -> datetime:
    return NOW - timedelta(days=days)


@pytest.fixture
def house(engine: Engine, tmp_path: Path, make_scene: Make) -> House:
    return House(engine, Storage(tmp_path / "data"), make_scene())


def test_without_a_rule_nothing_goes(house: House) -> None:
    made, file = house.job(10_000), house.file("a")
    house.sweep()
    assert (house.jobs, house.files) == ([made], [file])


def test_what_is_too_old_goes_with_the_files_that_it_alone_named(house: House) -> None:
    shared, own, fresh = house.file("a"), house.file("b"), house.file("c", days=0.5)
    house.job(9, shared)
    house.job(8, own)
    young = house.job(2, shared)
    pinned = house.job(50, pinned=True)
    unended = house.job(60, state="running", finished_at=None)
    house.sweep(days=7)
    assert set(house.jobs) == {young, pinned, unended}
    assert house.files == [shared, fresh], "what came today may be named soon"
    house.sweep(days=7)
    assert set(house.jobs) == {young, pinned, unended}


def test_the_oldest_go_until_the_rest_has_room(house: House) -> None:
    unused, used = house.file("a"), house.file("b")
    made = [house.job(days, used) for days in (5, 4, 3, 2)]
    house.sweep(size=10_000)
    assert house.jobs == made
    assert house.files == [used], "what none names goes first"
    house.sweep(size=250)
    assert house.jobs == made[2:], "450 bytes with the file that they share"
    house.sweep(size=0)
    assert (house.jobs, house.files) == ([], [])
    assert unused not in house.files


def test_what_another_render_is_held_against_stays_until_that_has_ended(house: House) -> None:
    truth = house.job(9)
    user = house.job(1, state="queued", finished_at=None, reference=truth)
    house.sweep(days=2)
    assert set(house.jobs) == {truth, user}
    with house.engine.begin() as connection:
        repository.cancel(connection, user, NOW)
    house.sweep(days=2)
    assert house.jobs == [user]


def test_variants_of_a_comparison_go_together_and_last(house: House) -> None:
    first, second = house.job(9, comparison="c"), house.job(3, comparison="c")
    between = house.job(5)
    house.sweep(days=4)
    assert house.jobs == [first, second]
    house.sweep(days=2)
    assert house.jobs == []
    assert between not in house.jobs


def test_what_would_go_is_what_goes(house: House) -> None:
    file = house.file("a")
    old = house.job(9, file)
    house.job(1)
    house.sweep()  # measures
    with house.engine.connect() as connection:
        found = due(connection, Rule(5, None), NOW)
    assert [group.jobs for group in found.groups] == [(old,)]
    assert [each.id for each in found.files] == [file]
    assert (found.kept, found.freed) == (250, 150)
    assert len(house.jobs) == 2, "it was only asked for"


def test_a_file_that_is_uploaded_again_is_not_collected(house: House) -> None:
    file = house.file("a")
    with house.engine.begin() as connection:
        assert files.use(connection, file)
    house.sweep(days=1)
    assert house.files == [file]
    with house.engine.connect() as connection:
        assert due(connection, FOREVER, NOW).files == []


def test_a_service_says_what_it_would_delete_and_deletes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, make_scene: Make
) -> None:
    settings = Settings(data=tmp_path, keep_size=1)
    house = House(open_database(settings.database), Storage(tmp_path), make_scene())
    unused, file = house.file("a"), house.file("b")
    pinned, gone = house.job(9, file, pinned=True), house.job(8, file)
    monkeypatch.setattr(application, "discover", list)
    with TestClient(application.create_app(settings), ADDRESS) as http:  # which sweeps when it starts
        end = time.monotonic() + 20
        while house.jobs != [pinned] or house.files != [file]:
            assert time.monotonic() < end
            time.sleep(0.05)
        assert http.get(f"/api/v1/jobs/{gone}").status_code == 404
        assert http.get(f"/api/v1/volumes/{unused}").status_code == 404
        told = http.get("/api/v1/retention").json()
        assert (told["size"], told["kept"], told["renders"]) == (1, 150, []), "what is pinned stays"
        assert http.patch(f"/api/v1/jobs/{pinned}", json={"pinned": False}).json()["pinned"] is False
        told = http.get("/api/v1/retention?days=7").json()
        assert [render["jobs"] for render in told["renders"]] == [[pinned]]
        assert (told["days"], told["size"], told["freed"]) == (7, None, 150)
    house.engine.dispose()
