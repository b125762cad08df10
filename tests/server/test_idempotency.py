"""A request that comes twice under one Idempotency-Key is done once."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from typing import Any

import pytest
from starlette.testclient import TestClient

from woodcock_server import idempotency

MakeScene = Callable[..., dict[str, Any]]
Post = Callable[..., Any]


@pytest.fixture
def post(client: TestClient, make_scene: MakeScene) -> Post:
    def submit(key: str, **more: Any) -> Any:
        return client.post("/api/v1/jobs", json={"scene": make_scene(), **more}, headers={"Idempotency-Key": key})

    return submit


def count(client: TestClient, tag: str) -> int:
    return len(client.get("/api/v1/jobs", params={"tag": tag, "limit": 200}).raise_for_status().json()["items"])


def test_the_first_answer_comes_again(client: TestClient, post: Post) -> None:
    """Also when the job is no longer as it was, or is no more."""
    first = post("a", name="one", tags=["again"])
    assert first.status_code == 201
    again = post("a", name="one", tags=["again"])
    assert (again.status_code, again.headers["Location"]) == (201, first.headers["Location"])
    assert again.json() == first.json()
    job = first.headers["Location"]
    client.post(f"{job}/cancel").raise_for_status()
    assert post("a", name="one", tags=["again"]).json() == first.json()
    client.delete(job).raise_for_status()
    assert post("a", name="one", tags=["again"]).json() == first.json()
    assert count(client, "again") == 0


def test_a_key_belongs_to_one_request(client: TestClient, post: Post) -> None:
    assert post("b", tags=["other"]).status_code == 201
    answer = post("b", tags=["other"], priority=1)
    assert answer.status_code == 422
    assert [fault["field"] for fault in answer.json()["errors"]] == ["Idempotency-Key"]
    assert post("c", tags=["other"]).status_code == 201
    assert count(client, "other") == 2


def test_one_that_is_tried_again_is_tried_once(client: TestClient, post: Post) -> None:
    first = post("h", tags=["tried"]).headers["Location"]
    client.post(f"{first}/cancel").raise_for_status()

    def retry(job: str, key: str) -> Any:
        return client.post(f"{job}/retry", headers={"Idempotency-Key": key})

    again = retry(first, "i")
    assert (again.status_code, count(client, "tried")) == (201, 2)
    assert retry(first, "i").json() == again.json()
    client.delete(first).raise_for_status()
    assert retry(first, "i").json() == again.json(), "also when what was tried again is no more"
    assert count(client, "tried") == 1
    other = again.headers["Location"]
    client.post(f"{other}/cancel").raise_for_status()
    assert retry(other, "i").status_code == 422, "the key belongs to another request"


def test_what_is_refused_leaves_the_key_free(post: Post) -> None:
    assert post("d", device="gpu7").status_code == 422
    assert post("d").status_code == 201


@pytest.mark.parametrize("key", ["", "x" * 256, "with space"])
def test_what_is_no_key(post: Post, key: str) -> None:
    answer = post(key)
    assert answer.status_code == 422
    assert "Idempotency-Key" in answer.json()["errors"][0]["field"]


def test_at_the_same_time(client: TestClient, post: Post) -> None:
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: post("e", tags=["together"]), range(16)))
    assert {answer.status_code for answer in answers} == {201}
    assert len({answer.headers["Location"] for answer in answers}) == 1
    assert count(client, "together") == 1


def test_keys_are_forgotten(client: TestClient, post: Post, monkeypatch: pytest.MonkeyPatch) -> None:
    assert post("f", tags=["forgotten"]).status_code == 201
    monkeypatch.setattr(idempotency, "KEPT", timedelta(seconds=-1))
    post("g")
    assert post("f", tags=["forgotten"]).status_code == 201
    assert count(client, "forgotten") == 2
