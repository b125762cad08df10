"""What one owner may have at a time, and whose turn it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Engine, update
from starlette.testclient import TestClient

from woodcock_server import app as application
from woodcock_server.access import tokens
from woodcock_server.access.tokens import Scope
from woodcock_server.config import Settings
from woodcock_server.database import open_database
from woodcock_server.devices.choice import ANY
from woodcock_server.jobs import repository
from woodcock_server.tables import jobs

from .conftest import ADDRESS, SCENE
from .files import npy

Make = Callable[..., dict[str, Any]]
NOW = datetime(2030, 1, 2, 3, 4, 5, tzinfo=UTC)


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    return Settings(data=tmp_path, owner_jobs=3, owner_paths=16 * 16 * 100, owner_storage=1000)


@pytest.fixture
def http(settings: Settings, monkeypatch: pytest.MonkeyPatch) -> Iterator[TestClient]:
    monkeypatch.setattr(application, "discover", list)
    with TestClient(application.create_app(settings), ADDRESS) as http:
        yield http


@pytest.fixture
def bearer(settings: Settings) -> Callable[[str], dict[str, str]]:
    """The header of a token of an owner."""

    def make(owner: str) -> dict[str, str]:
        with open_database(settings.database).begin() as connection:
            _, text = tokens.create(connection, "a token", owner, Scope.WRITE, NOW, None)
        return {"Authorization": f"Bearer {text}"}

    return make


def test_what_would_be_too_much_is_told_beforehand(http: TestClient, make_scene: Make) -> None:
    validate = "/api/v1/jobs/validate"
    answer = http.post(validate, json={"scene": make_scene(samples=101)})
    assert (answer.status_code, [fault["field"] for fault in answer.json()["errors"]]) == (422, ["scene.stop"])
    assert http.post("/api/v1/jobs", json={"scene": make_scene(samples=60)}).status_code == 201
    assert http.post(validate, json={"scene": make_scene(samples=60)}).status_code == 429
    assert http.post(validate, json={"scene": make_scene(samples=40)}).status_code == 204


def test_more_jobs_than_an_owner_may_have_wait_outside(
    http: TestClient, make_scene: Make, bearer: Callable[[str], dict[str, str]]
) -> None:
    ann, bob = bearer("ann"), bearer("bob")
    body = {"scene": make_scene(samples=1)}
    made = [http.post("/api/v1/jobs", json=body, headers=ann).json() for _ in range(3)]
    assert {job["owner"] for job in made} == {"ann"}
    refused = http.post("/api/v1/jobs", json=body, headers=ann)
    assert (refused.status_code, refused.headers["retry-after"]) == (429, "30")
    assert refused.json()["detail"] == "3 of your jobs have not ended; 3 may wait at a time."
    assert http.post("/api/v1/jobs", json=body, headers=bob).status_code == 201
    assert http.post(f"/api/v1/jobs/{made[0]['id']}/cancel", headers=ann).status_code == 202
    assert http.post("/api/v1/jobs", json=body, headers=ann).status_code == 201
    assert http.post(f"/api/v1/jobs/{made[0]['id']}/retry", headers=ann).status_code == 429
    compared = {"scene": make_scene(), "vary": {"majorant": ["global", "grid"]}, "seconds": 1}
    assert http.post("/api/v1/comparisons", json=compared, headers=ann).status_code == 429
    swept = {"scene": make_scene(samples=1), "product": {"seed": [1, 2]}}
    assert http.post("/api/v1/batches", json=swept, headers=ann).status_code == 429
    assert {job["state"] for job in http.get("/api/v1/jobs?owner=ann", headers=ann).json()["items"]} == {
        "queued",
        "cancelled",
    }
    batch = http.post("/api/v1/batches", json=swept, headers=bob).json()
    assert (batch["owner"], len(batch["jobs"])) == ("bob", 2)
    assert http.post("/api/v1/comparisons", json=compared, headers=bearer("cleo")).json()["owner"] == "cleo"
    swept["product"] = {"seed": [1, 2, 3, 4]}
    never = http.post("/api/v1/batches", json=swept, headers=ann)
    assert (never.status_code, never.json()["detail"]) == (
        422,
        "4 jobs are more than one owner may have here at a time, 3.",
    )
    owned = http.get("/api/v1/jobs?owner=bob", headers=ann).json()["items"]
    assert [job["owner"] for job in owned] == ["bob"] * 3


def test_owners_choose_keys_without_knowing_of_each_other(
    http: TestClient, make_scene: Make, bearer: Callable[[str], dict[str, str]]
) -> None:
    ann, bob = ({**bearer(owner), "Idempotency-Key": "1"} for owner in ("ann", "bob"))
    made = [http.post("/api/v1/jobs", json={"scene": make_scene()}, headers=who).json() for who in (ann, bob, ann)]
    assert [job["owner"] for job in made] == ["ann", "bob", "ann"]
    assert made[0] == made[2]
    other = http.post("/api/v1/jobs", json={"scene": make_scene(), "name": "b"}, headers=bob)
    assert other.status_code == 422


def test_samples_of_pixels_are_counted_and_what_never_fits_is_refused_for_good(
    http: TestClient, make_scene: Make
) -> None:
    assert http.post("/api/v1/jobs", json={"scene": make_scene(samples=60)}).status_code == 201
    seconds = make_scene(stop={"kind": "seconds", "seconds": 1e6})
    assert http.post("/api/v1/jobs", json={"scene": seconds}).status_code == 201, "time is its own limit"
    refused = http.post("/api/v1/jobs", json={"scene": make_scene(samples=41)})
    assert refused.status_code == 429
    assert refused.json()["detail"].startswith("Your jobs that have not ended ask for 15360 samples of pixels")
    never = http.post("/api/v1/jobs", json={"scene": make_scene(samples=101)})
    assert never.status_code == 422
    assert never.json()["errors"] == [
        {"field": "scene.stop", "message": "asks for 25856 samples of pixels; 25600 at most"}
    ]


def test_files_take_room_and_renders_do(http: TestClient, make_scene: Make, settings: Settings) -> None:
    def upload(size: int) -> Any:
        return http.post(
            "/api/v1/volumes?name=a.npy",
            content=npy([[[0.5] * size]]),
            headers={"Content-Type": "application/octet-stream"},
        )

    assert upload(100).status_code == 201
    refused = upload(101)
    assert (refused.status_code, refused.headers["retry-after"]) == (429, "3600")
    assert upload(100).status_code == 200, "what is there takes no more room"
    assert len(list((settings.data / "volumes").iterdir())) == 1
    job = http.post("/api/v1/jobs", json={"scene": make_scene(samples=1)}).json()
    with open_database(settings.database).begin() as connection:
        repository.measured(connection, {job["id"]: 900})
    assert http.post("/api/v1/jobs", json={"scene": make_scene(samples=1)}).status_code == 429


def submit(engine: Engine, owner: str, priority: int = 0) -> str:
    with engine.begin() as connection:
        asked = {"name": "", "scene": SCENE, "device": ANY, "owner": owner, "priority": priority}
        return repository.add(connection, asked, NOW)


def turn(engine: Engine, now: datetime) -> str:
    """Whose job is next; it is rendered, and takes ten seconds."""
    with engine.connect() as connection:
        job_id = repository.next_claimable(connection, now, [ANY])
    assert job_id is not None
    with engine.begin() as connection:
        row = repository.claim(connection, job_id, "a server", now, timedelta(seconds=1))
        assert row is not None
        assert repository.write_held(connection, job_id, row["token"], {"seconds": 10.0, "state": "succeeded"})
    return str(row["owner"])


def test_owners_take_turns_by_what_they_had(engine: Engine) -> None:
    for owner in ("ann", "ann", "ann", "bob", "cleo", "bob"):
        submit(engine, owner)
    assert [turn(engine, NOW) for _ in range(6)] == ["ann", "bob", "cleo", "ann", "bob", "ann"]
    for owner in ("ann", "dora"):
        submit(engine, owner)
    assert turn(engine, NOW) == "dora", "who had nothing yet comes first"
    submit(engine, "dora")
    assert turn(engine, NOW + timedelta(days=2)) == "ann", "by the day, and the oldest of equals"


def test_priority_goes_before_turns(engine: Engine) -> None:
    for owner, priority in (("ann", 0), ("bob", 1), ("bob", 1), ("ann", 1)):
        submit(engine, owner, priority)
    assert [turn(engine, NOW) for _ in range(4)] == ["bob", "ann", "bob", "ann"]


def test_what_was_rendered_long_ago_does_not_count(engine: Engine) -> None:
    submit(engine, "ann")
    assert turn(engine, NOW) == "ann"
    with engine.begin() as connection:
        connection.execute(update(jobs).values(started_at=NOW - timedelta(days=1, seconds=1)))
    submit(engine, "ann")
    submit(engine, "bob")
    assert turn(engine, NOW) == "ann"
