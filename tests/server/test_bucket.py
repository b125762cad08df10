"""Files in a bucket: the rows say what is a job's, whoever else writes; what is said while it is out of reach.

The store is obstore's own in memory; test_s3.py has a real server.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import obstore
import pytest
from obstore.store import MemoryStore, ObjectStore
from sqlalchemy import Engine, insert
from starlette.testclient import TestClient

from woodcock_server import app as application
from woodcock_server import bucket, copies, store
from woodcock_server.bucket import BucketStorage
from woodcock_server.config import Settings
from woodcock_server.database import open_database
from woodcock_server.storage import Collected, StoreAway, film_name
from woodcock_server.store import Store
from woodcock_server.tables import volumes

from .conftest import ADDRESS
from .test_volumes import npy, upload

JOB, OTHER = "0190-job", "0190-other"
CONTENT = b"what was uploaded"
FILE = f"sha256:{hashlib.sha256(CONTENT).hexdigest()}"
#: A bucket at which nobody answers.
NOBODY = {"AWS_ENDPOINT_URL": "http://127.0.0.1:9", "AWS_ACCESS_KEY_ID": "a", "AWS_SECRET_ACCESS_KEY": "b"}

Make = Callable[[str], BucketStorage]


@pytest.fixture
def objects() -> ObjectStore:
    return MemoryStore()


@pytest.fixture
def engine(tmp_path: Path) -> Iterator[Engine]:
    engine = open_database(f"sqlite:///{tmp_path / 'test.sqlite'}")
    yield engine
    engine.dispose()


@pytest.fixture
def server(tmp_path: Path, engine: Engine, objects: ObjectStore) -> Iterator[Make]:
    """Makes a server's storage in a data folder of that name; all share the bucket and the database."""
    made = list[BucketStorage]()

    def make(name: str) -> BucketStorage:
        made.append(BucketStorage(tmp_path / name, engine, Store(objects), 1 << 20))
        return made[-1]

    yield make
    for each in made:
        each.close()


def keys(objects: ObjectStore) -> list[str]:
    return sorted(each["path"] for page in obstore.list(objects) for each in page)


def publish(server: BucketStorage, engine: Engine, token: int, name: str, content: bytes, held: bool = True) -> None:
    """As a holder of the token does, whether it still holds the job or not."""
    (server.stage(JOB, token) / name).write_bytes(content)
    with server.publishing(JOB, token) as put_in_place, engine.begin() as connection:
        if held:
            put_in_place(connection)


def bring(server: BucketStorage, engine: Engine) -> None:
    row = {"id": FILE, "entry": "1", "name": "x", "size": len(CONTENT), "type": "volume", "grids": []}
    with server.upload() as uploaded:
        uploaded.write(CONTENT)
        assert f"sha256:{uploaded.finish()}" == FILE
        with server.bringing_volume(uploaded.path, FILE) as keep, engine.begin() as connection:
            connection.execute(insert(volumes), {**row, "created_at": datetime.now(UTC)})
            keep()


def test_what_one_server_publishes_another_reads(server: Make, engine: Engine, objects: ObjectStore) -> None:
    one, other = server("one"), server("other")
    assert not one.job_file(JOB, "preview.png").exists()
    publish(one, engine, 1, "preview.png", b"first")
    assert other.job_file(JOB, "preview.png").read_bytes() == b"first"
    publish(one, engine, 1, "preview.png", b"second")
    for each in (one, other):
        path = each.job_file(JOB, "preview.png")
        assert (path.name.endswith("preview.png"), path.read_bytes()) == (True, b"second")
        assert (each.size(JOB), each.folders()) == (6, {JOB})
    assert len(keys(objects)) == 1, "what was replaced is gone"
    assert not list(one.jobs.iterdir()), "nothing stays of what was on its way"


def test_who_lost_the_lease_changes_nothing_and_leaves_nothing(
    server: Make, engine: Engine, objects: ObjectStore
) -> None:
    asleep, awake = server("asleep"), server("awake")
    publish(awake, engine, 2, "image.exr", b"of the second claim")
    before = keys(objects)
    publish(asleep, engine, 1, "image.exr", b"of the first claim", held=False)
    assert keys(objects) == before
    assert asleep.job_file(JOB, "image.exr").read_bytes() == b"of the second claim"


def test_a_transaction_that_fails_leaves_what_was(server: Make, engine: Engine, objects: ObjectStore) -> None:
    one = server("one")
    publish(one, engine, 1, "image.exr", b"before")
    (one.stage(JOB, 1) / "image.exr").write_bytes(b"after")

    def fail() -> None:
        with one.publishing(JOB, 1) as put_in_place, engine.begin() as connection:
            put_in_place(connection)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert server("other").job_file(JOB, "image.exr").read_bytes() == b"before"


def test_the_newest_film_counts_and_is_handed_on(server: Make, engine: Engine, objects: ObjectStore) -> None:
    one = server("one")
    assert one.newest_checkpoint(JOB) is None
    assert not one.hand_on(JOB, OTHER)
    for token in (2, 10):
        publish(one, engine, token, film_name(token), b"%d" % token)
    film = one.newest_checkpoint(JOB)
    assert film is not None
    assert film.read_bytes() == b"10"
    one.drop_checkpoints(JOB, 10)
    publish(one, engine, 10, "preview.png", b"picture")
    assert one.hand_on(JOB, OTHER)
    one.remove_job(JOB)
    assert one.job_file(OTHER, film_name(0)).read_bytes() == b"10"
    assert one.job_file(OTHER, "preview.png").read_bytes() == b"picture"
    one.remove_job(OTHER)
    assert keys(objects) == []
    assert one.folders() == set()


def test_an_upload_is_fetched_once_and_checked(server: Make, engine: Engine, objects: ObjectStore) -> None:
    one, other = server("one"), server("other")
    assert not one.has_volume(FILE)
    bring(one, engine)
    assert (one.has_volume(FILE), keys(objects)) == (True, [bucket.volume_key(FILE)])
    with other.volume_files([FILE]) as paths:
        assert paths[FILE].read_bytes() == CONTENT
    obstore.put(objects, bucket.volume_key(FILE), b"other bytes")
    assert other.volume_file(FILE).read_bytes() == CONTENT, "it is not fetched again"
    third = server("third")
    path = third.volume_file(FILE)
    assert not path.exists(), "these bytes are not what was uploaded"
    assert third.by_id(f"{path} cannot be read") == f"{FILE} cannot be read"
    one.drop_volume(FILE)
    assert keys(objects) == []


def test_a_part_of_an_upload_is_read_without_a_copy(server: Make, engine: Engine) -> None:
    one, other = server("one"), server("other")
    bring(one, engine)
    assert other.read_volume(FILE, 5, 3) == CONTENT[5:8]
    assert other.read_volume(FILE, 5, 300) == CONTENT[5:]
    assert not other.copies.path(bucket.volume_key(FILE)).exists()
    one.drop_volume(FILE)
    for ask in (lambda: other.read_volume(FILE, 5, 3), lambda: other.volume_source(FILE)):
        with pytest.raises(FileNotFoundError, match=r"^the object store has it no more$"):
            ask()


def test_a_file_that_is_collected_as_it_comes_is_brought_again(
    server: Make, engine: Engine, objects: ObjectStore, tmp_path: Path
) -> None:
    (tmp_path / "upload").write_bytes(CONTENT)
    one = server("one")

    def bring_late() -> None:
        with one.bringing_volume(tmp_path / "upload", FILE) as keep:
            one.drop_volume(FILE)
            keep()

    with pytest.raises(Collected):
        bring_late()
    assert (tmp_path / "upload").exists()


def test_what_no_row_names_is_collected_a_day_later(
    server: Make, engine: Engine, objects: ObjectStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = server("one")
    publish(one, engine, 1, "image.exr", b"named")
    bring(one, engine)
    named = keys(objects)
    for key in (f"jobs/{JOB}/left/image.exr", "volumes/left"):
        obstore.put(objects, key, b"left by a server that was killed")
    one.collect()
    assert len(keys(objects)) == 4, "they may be on their way to a row"
    monkeypatch.setattr(bucket, "GRACE", -timedelta(seconds=60))
    one.collect()
    assert len(keys(objects)) == 4, "it is looked for once a day"
    server("other").collect()
    assert keys(objects) == named


def test_copies_make_room_but_for_what_is_held(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(copies, "GRACE", 0.0)
    kept, fetched = copies.Copies(tmp_path, 250), list[str]()

    def get(key: str) -> Path:
        def fetch(path: Path) -> None:
            fetched.append(key)
            path.write_bytes(bytes(100))

        return kept.get(key, fetch)

    with kept.holding(["a"]):
        paths = [get(key) for key in ("a", "b", "c", "d")]
        assert [path.exists() for path in paths] == [True, False, False, True]
        get("a")
    for key in ("b", "c"):
        get(key)
    assert fetched == ["a", "b", "c", "d", "b", "c"]
    with pytest.raises(OSError, match="each has its own"):
        copies.Copies(tmp_path, 250)
    kept.close()
    again = copies.Copies(tmp_path, 250)
    assert again.get("c", lambda _: pytest.fail("it was there")).exists()
    again.close()


# While the store is out of reach


def test_a_store_that_does_not_answer_is_asked_again_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "LOOK_EVERY", 0.05)
    objects, down = MemoryStore(), [True]
    put = obstore.put

    def refuse(*args: Any, **how: Any) -> Any:
        if down[0]:
            raise obstore.exceptions.GenericError("nobody listens")
        return put(*args, **how)

    monkeypatch.setattr(obstore, "put", refuse)
    asked = Store(objects)
    with pytest.raises(StoreAway):
        asked.put("a", b"1")
    with pytest.raises(StoreAway):
        asked.size("a")
    down[0] = False
    end = time.monotonic() + 10
    while True:
        try:
            asked.put("a", b"1")
            break
        except StoreAway:
            assert time.monotonic() < end
            time.sleep(0.01)
    assert asked.size("a") == 1


@pytest.fixture
def cut_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[TestClient]:
    """A service whose bucket nobody answers for, from its start on."""
    for name, value in NOBODY.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(application, "discover", list)
    app = application.create_app(Settings(data=tmp_path / "data", store="s3://bucket/renders"))
    with TestClient(app, ADDRESS, raise_server_exceptions=False) as client:
        yield client


def test_what_needs_a_store_that_is_away_is_refused_and_the_rest_goes_on(
    cut_off: TestClient, make_scene: Callable[..., dict[str, Any]]
) -> None:
    sentence = "The object store does not answer; the server's log says why."
    for answer in (upload(cut_off, npy()), cut_off.get("/readyz")):
        assert (answer.status_code, answer.headers["content-type"]) == (503, "application/problem+json")
        assert answer.json()["detail"] == sentence
    assert cut_off.get("/api/v1/volumes").json()["items"] == [], "no row is left of it"
    job = cut_off.post("/api/v1/jobs", json={"scene": make_scene()})
    assert job.status_code == 201, "its files are not needed yet"
    cut_off.post(f"/api/v1/jobs/{job.json()['id']}/cancel").raise_for_status()
    assert cut_off.delete(f"/api/v1/jobs/{job.json()['id']}").status_code == 204
