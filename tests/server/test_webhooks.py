"""Who is to be told of a job's end: what is taken and shown, and that every end is told."""

from __future__ import annotations

import base64
import io
import json
import time
import traceback
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from ipaddress import ip_network
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import Connection, Engine, create_engine, text
from sqlalchemy.exc import SQLAlchemyError
from starlette.testclient import TestClient

from woodcock_server.config import Settings
from woodcock_server.database import open_database
from woodcock_server.devices.choice import ANY
from woodcock_server.jobs import repository
from woodcock_server.jobs.states import State

from .conftest import SCENE, Service
from .receiver import SECRET, Receiver

MakeScene = Callable[..., dict[str, Any]]

#: Nothing has this name: what is cancelled here is told to nobody.
URL = "https://receiver.invalid/hook?key=1"
OTHER = "whsec_" + base64.b64encode(b"another secret of 25 byte").decode()
NOW = datetime(2030, 1, 2, 3, 4, 5, tzinfo=UTC)


# What is taken and shown


def test_the_webhook_is_shown_and_the_secret_never(client: TestClient, make_scene: MakeScene, data: Path) -> None:
    body = {"scene": make_scene(), "tags": ["told"], "webhook": {"url": URL, "secret": SECRET}}
    key = {"Idempotency-Key": "told"}
    made = client.post("/api/v1/jobs", json=body, headers=key)
    job = made.json()["links"]["self"]
    answers = [
        made,
        client.post("/api/v1/jobs", json=body, headers=key),
        client.post("/api/v1/jobs", json=body | {"webhook": {"url": URL, "secret": OTHER}}, headers=key),
        client.post("/api/v1/jobs/check", json=body),
        client.get(job),
        client.get("/api/v1/jobs", params={"tag": "told"}),
        client.patch(job, json={"name": "a"}),
        client.post(f"{job}/cancel"),
        client.get(f"{job}/events"),
        client.post(f"{job}/retry"),
    ]
    assert [each.status_code for each in answers] == [201, 201, 422, 200, 200, 200, 200, 202, 200, 201]
    waits = {"url": URL, "state": "waiting", "attempts": 0, "error": None}
    assert made.json()["webhook"] == waits
    assert answers[5].json()["items"][0]["webhook"] == waits
    again = answers[-1].json()
    assert again["webhook"] == waits, "a new attempt is told of as the first was"
    for each in answers:
        assert SECRET not in each.text
        assert OTHER not in each.text
    engine = create_engine(Settings(data=data).database)
    with engine.connect() as connection:
        kept = connection.execute(text("SELECT secret, url FROM webhooks WHERE job_id = :id"), {"id": again["id"]})
        assert kept.all() == [(SECRET, URL)]
        assert SECRET not in connection.scalar(text("SELECT answer FROM answers WHERE key = 'told'"))
    engine.dispose()
    assert client.post("/api/v1/jobs", json={"scene": make_scene()}).json()["webhook"] is None


@pytest.mark.parametrize(
    ("webhook", "field", "says"),
    [
        ({"url": URL}, "webhook.secret", "is required"),
        ({"secret": SECRET}, "webhook.url", "is required"),
        ({"url": "ftp://example.org/", "secret": SECRET}, "webhook.url", "'http' or 'https'"),
        ({"url": "file:///etc/passwd", "secret": SECRET}, "webhook.url", "'http' or 'https'"),
        ({"url": "http://", "secret": SECRET}, "webhook.url", "empty host"),
        ({"url": "https://me:hidden@example.org/", "secret": SECRET}, "webhook.url", "user name"),
        ({"url": "https://me@example.org/", "secret": SECRET}, "webhook.url", "user name"),
        ({"url": f"https://example.org/{'x' * 2100}", "secret": SECRET}, "webhook.url", "at most"),
        ({"url": URL, "secret": SECRET[6:]}, "webhook.secret", "whsec_ and base64 of 24 to 64 random bytes"),
        ({"url": URL, "secret": SECRET[:-4]}, "webhook.secret", "24 to 64"),
        ({"url": URL, "secret": "whsec_" + "A" * 88}, "webhook.secret", "24 to 64"),
        ({"url": URL, "secret": SECRET + "é"}, "webhook.secret", "24 to 64"),
        ({"url": URL, "secret": SECRET[:-1]}, "webhook.secret", "24 to 64"),
        ({"url": URL, "secret": SECRET, "events": []}, "webhook.events", "is not a known key"),
        ({"url": URL, "token": SECRET}, "webhook.token", "is not a known key"),
        (SECRET, "webhook", "valid dictionary"),
    ],
)
def test_a_fault_of_a_webhook_is_named_and_what_it_has_is_not_told_back(
    client: TestClient, make_scene: MakeScene, webhook: Any, field: str, says: str
) -> None:
    answer = client.post("/api/v1/jobs", json={"scene": make_scene(), "webhook": webhook})
    assert answer.status_code == 422
    faults = {fault["field"]: fault["message"] for fault in answer.json()["errors"]}
    assert says in faults[field]
    assert SECRET[6:30] not in answer.text
    assert "hidden" not in answer.text


def test_a_setting_that_is_no_network_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WOODCOCK_WEBHOOK_NETWORKS", "10.0.0.0/8, fd00::/8,")
    assert Settings().webhook_networks == (ip_network("10.0.0.0/8"), ip_network("fd00::/8"))
    monkeypatch.setenv("WOODCOCK_WEBHOOK_NETWORKS", "10.0.0.1/8")
    with pytest.raises(ValueError, match=r"webhook_networks\n.*10.0.0.1/8 has host bits set"):
        Settings()


# The outbox: what is due is written with the end


@pytest.fixture
def engine(tmp_path: Path) -> Iterator[Engine]:
    engine = open_database(f"sqlite:///{tmp_path / 'test.sqlite'}")
    yield engine
    engine.dispose()


def claimed(connection: Connection, job: str) -> int:
    row = repository.claim(connection, job, "a server", NOW, timedelta(seconds=1))
    assert row is not None
    return int(row["token"])


def by_its_holder(state: State) -> Callable[[Connection, str], bool]:
    return lambda connection, job: repository.write_held(connection, job, claimed(connection, job), {"state": state})


def while_it_is_queued(connection: Connection, job: str) -> bool:
    return repository.cancel(connection, job, NOW)


def while_it_is_rendered(connection: Connection, job: str) -> bool:
    token = claimed(connection, job)
    assert repository.cancel(connection, job, NOW)
    assert due(connection, job) is None, "it is being rendered yet"
    return repository.let_go(connection, job, token, NOW)


def abandoned(connection: Connection, job: str) -> bool:
    claimed(connection, job)
    assert repository.cancel(connection, job, NOW)
    ((found, token),) = repository.abandoned(connection, NOW + timedelta(seconds=2))
    return repository.let_go(connection, found, token, NOW)


def due(connection: Connection, job: str) -> Any:
    return connection.scalar(text("SELECT due_at FROM webhooks WHERE job_id = :job"), {"job": job})


@pytest.mark.parametrize(
    "end",
    [by_its_holder(State.SUCCEEDED), by_its_holder(State.FAILED), while_it_is_queued, while_it_is_rendered, abandoned],
    ids=["succeeded", "failed", "cancelled while queued", "cancelled while rendered", "abandoned"],
)
def test_every_end_is_due_in_its_own_transaction(engine: Engine, end: Callable[[Connection, str], bool]) -> None:
    asked = {"name": "", "scene": SCENE, "device": ANY, "webhook": {"url": URL, "secret": SECRET}}
    with engine.begin() as connection:
        job, other = (repository.add(connection, asked, NOW) for _ in range(2))
    with engine.connect() as connection:
        assert end(connection, job)
        assert due(connection, job) is not None
        connection.rollback()  # as by a crash before the commit
        assert due(connection, job) is None
        assert not State((repository.get(connection, job) or {})["state"]).final
    with engine.begin() as connection:
        assert end(connection, job)
    with engine.connect() as connection:
        assert due(connection, job) is not None
        assert due(connection, other) is None


def test_a_job_that_goes_back_into_the_queue_is_not_due(engine: Engine) -> None:
    asked = {"name": "", "scene": SCENE, "device": ANY, "webhook": {"url": URL, "secret": SECRET}}
    with engine.begin() as connection:
        job = repository.add(connection, asked, NOW)
        assert by_its_holder(State.QUEUED)(connection, job)
        assert due(connection, job) is None


def test_an_error_of_the_database_tells_no_secret(engine: Engine) -> None:
    asked = {"name": "", "scene": SCENE, "device": ANY, "webhook": {"url": URL, "secret": SECRET}}
    with engine.begin() as connection:
        connection.execute(text("CREATE TRIGGER t BEFORE INSERT ON webhooks BEGIN SELECT RAISE(ABORT, 'full'); END"))
    with pytest.raises(SQLAlchemyError, match="INSERT INTO webhooks") as caught, engine.begin() as connection:
        repository.add(connection, asked, NOW)
    assert SECRET not in "".join(traceback.format_exception(caught.value))


# The service


def test_internal_receivers_are_not_told_unless_they_are_allowed(client: TestClient, make_scene: MakeScene) -> None:
    with Receiver() as receiver:
        webhook = {"url": receiver.url, "secret": SECRET}
        job = client.post("/api/v1/jobs", json={"scene": make_scene(), "webhook": webhook}).json()["links"]["self"]
        client.post(f"{job}/cancel").raise_for_status()
        end = time.monotonic() + 10
        while not (told := client.get(job).json()["webhook"])["error"]:
            assert time.monotonic() < end
            time.sleep(0.05)
    assert (told["state"], told["attempts"], receiver.connections) == ("waiting", 1, 0)
    assert "WOODCOCK_WEBHOOK_NETWORKS" in told["error"]


def test_ends_are_told_by_the_service(service: Service, make_scene: MakeScene) -> None:
    """Succeeded, failed, cancelled while it is rendered, and succeeded anew where that is gone on from."""
    negative = io.BytesIO()
    np.save(negative, np.full((2, 2, 2), -1, np.float32))
    file = service.http.post("/api/v1/volumes?name=a.npy", content=negative.getvalue()).raise_for_status().json()["id"]
    with Receiver() as receiver:
        webhook = {"url": receiver.url, "secret": SECRET}
        done = service.submit(make_scene(), webhook=webhook)
        service.wait(done, lambda job: bool(job["finished_at"]))
        stop = {"stop": {"kind": "samples", "samples": 16}}
        more = service.http.post(f"/api/v1/jobs/{done}/extend", json=stop).raise_for_status().json()["id"]
        wrong = make_scene(volumes=[{"kind": "grid", "file": file, "albedo": 0.5}])
        failed = service.submit(wrong, webhook=webhook)
        stopped = service.submit(make_scene(64, 1 << 22), webhook=webhook)
        service.wait(stopped, lambda job: bool(job["samples"]))
        service.http.post(f"/api/v1/jobs/{stopped}/cancel").raise_for_status()
        heard = {each.headers["webhook-id"]: each for each in receiver.wait(4)}
        end = service.wait(stopped, lambda job: job["webhook"]["state"] == "delivered", 10)
    assert len(heard) == len(receiver.heard) == 4
    assert all(each.proven() for each in heard.values())
    types = {job: json.loads(each.body)["type"] for job, each in heard.items()}
    assert types == {
        done: "job.succeeded", more: "job.succeeded", failed: "job.failed", stopped: "job.cancelled",
    }  # fmt: skip
    assert "negative densities" in json.loads(heard[failed].body)["data"]["error"]
    assert json.loads(heard[done].body)["data"]["links"]["image"] == f"/api/v1/jobs/{done}/image.exr"
    assert end["webhook"] == {"url": receiver.url, "state": "delivered", "attempts": 1, "error": None}
    assert SECRET not in service.log.read_text()
