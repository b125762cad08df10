"""The life of a job: it is changed, cancelled, tried again and deleted, and no state turns back."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient
from tests.server.conftest import Service

from woodcock_server.jobs.states import State

MakeScene = Callable[..., dict[str, Any]]


@pytest.fixture
def submit(client: TestClient, make_scene: MakeScene) -> Callable[..., str]:
    def post(**more: Any) -> str:
        answer = client.post("/api/v1/jobs", json={"scene": make_scene(), **more})
        assert answer.status_code == 201, answer.text
        return str(answer.json()["id"])

    return post


def problem(answer: Any, status: int) -> str:
    assert answer.status_code == status, answer.text
    assert answer.headers["Content-Type"] == "application/problem+json"
    return str(answer.json()["detail"])


# States


def test_every_state_is_reached_and_every_life_ends() -> None:
    """From the queue each state is reached, and from each an end is."""
    for state in State:
        assert state is State.QUEUED or state.before
    assert {state for state in State if state.final} == {State.SUCCEEDED, State.FAILED, State.CANCELLED}
    reached = {state for state in State if state.final}
    while grown := {before for state in reached for before in state.before} - reached:
        reached |= grown
    assert reached == set(State)


def test_an_end_never_turns_back() -> None:
    for state in State:
        assert not [before for before in state.before if before.final]


# What happened


def stream(client: TestClient, job: str, **headers: str) -> list[tuple[str, int | None, str]]:
    """Of every event its kind, its id and the state that it tells."""
    text = client.get(f"/api/v1/jobs/{job}/events", headers=headers).text
    found = []
    for block in text.replace("\r\n", "\n").split("\n\n"):
        fields = dict(line.split(": ", 1) for line in block.splitlines() if not line.startswith(":"))
        if "event" in fields:
            id = int(fields["id"]) if "id" in fields else None
            found.append((fields["event"], id, json.loads(fields["data"])["state"]))
    return found


def test_who_lost_the_stream_misses_no_state(client: TestClient, submit: Callable[..., str]) -> None:
    job, other = submit(), submit()
    for each in (job, other):
        assert client.post(f"/api/v1/jobs/{each}/cancel").status_code == 202
    seen = stream(client, job)
    assert [(event, state) for event, _, state in seen] == [
        ("state", "queued"), ("state", "cancelled"), ("end", "cancelled"),
    ]  # fmt: skip
    (_, first, _), (_, second, _), (_, of_end, _) = seen
    assert first is not None
    assert second is not None
    assert of_end is None, "only what is kept has an id"
    assert first < second
    assert stream(client, job, **{"Last-Event-ID": str(first)}) == seen[1:]
    assert stream(client, job, **{"Last-Event-ID": str(second)}) == seen[2:]
    assert stream(client, job, **{"Last-Event-ID": "nonsense"}) == seen


# Changes


def test_names_tags_and_priorities(client: TestClient, submit: Callable[..., str]) -> None:
    job = submit(name="a", tags=["smoke", "b", "smoke"], priority=3)
    made = client.get(f"/api/v1/jobs/{job}").json()
    assert (made["tags"], made["priority"], made["retry_of"]) == (["b", "smoke"], 3, None)
    changed = client.patch(f"/api/v1/jobs/{job}", json={"tags": ["c"]}).raise_for_status().json()
    assert (changed["name"], changed["tags"], changed["priority"]) == ("a", ["c"], 3)
    changed = client.patch(f"/api/v1/jobs/{job}", json={"name": "b", "priority": -3}).raise_for_status().json()
    assert changed == client.get(f"/api/v1/jobs/{job}").json()
    assert (changed["name"], changed["tags"], changed["priority"]) == ("b", ["c"], -3)
    assert client.patch(f"/api/v1/jobs/{job}", json={}).json() == changed


@pytest.mark.parametrize(
    ("body", "field"),
    [({"priority": 101}, "priority"), ({"tags": [""]}, "tags[0]"), ({"tags": ["x"] * 21}, "tags"),
     ({"scene": {}}, "scene"), ({"name": "x" * 201}, "name"), ({"state": "succeeded"}, "state")],
)  # fmt: skip
def test_what_cannot_be_changed(client: TestClient, submit: Callable[..., str], body: Any, field: str) -> None:
    answer = client.patch(f"/api/v1/jobs/{submit()}", json=body)
    assert problem(answer, 422)
    assert [fault["field"] for fault in answer.json()["errors"]] == [field]


def test_jobs_are_found_by_their_tags(client: TestClient, submit: Callable[..., str]) -> None:
    first, second = (submit(tags=[tag, "of this test"]) for tag in ("one", "two"))

    def found(tag: str, **more: Any) -> list[str]:
        page = client.get("/api/v1/jobs", params={"tag": tag, **more}).raise_for_status().json()
        return [job["id"] for job in page["items"]]

    assert found("of this test") == [second, first]
    assert found("one") == [first]
    assert found("one", state="running") == found("on") == []
    client.post(f"/api/v1/jobs/{first}/cancel").raise_for_status()
    assert found("of this test", state=["cancelled", "queued"]) == [second, first]
    assert found("of this test", state=["cancelled", "failed"]) == [first]


def test_jobs_are_found_by_their_names_and_times(client: TestClient, submit: Callable[..., str]) -> None:
    jobs = [submit(name=name, tags=["named"]) for name in ("Über 100% fog", "uber_fog", "FOG")]
    times = [client.get(f"/api/v1/jobs/{job}").json()["created_at"] for job in jobs]

    def found(**asked: Any) -> list[int]:
        page = client.get("/api/v1/jobs", params={"tag": "named", **asked}).raise_for_status().json()
        return [jobs.index(job["id"]) for job in page["items"]]

    assert found(text="fog") == [2, 1, 0]
    assert found(text="0%") == [0]
    assert found(text="r_f") == [1]
    assert found(since=times[1]) == [2, 1]
    assert found(before=times[1]) == [0]
    assert found(since=times[1], before=times[2]) == [1]
    answer = client.get("/api/v1/jobs", params={"since": "2026-01-01T00:00:00"})
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["field"] == "since"


def test_pages_of_what_was_asked_for(client: TestClient, submit: Callable[..., str]) -> None:
    jobs = [submit(tags=["page", "two & more"]) for _ in range(3)]
    asked = {"tag": "two & more", "state": ["queued", "failed"], "limit": 2}
    first = client.get("/api/v1/jobs", params=asked)
    following = client.get(first.links["next"]["url"])
    found = [job["id"] for page in (first, following) for job in page.json()["items"]]
    assert found == jobs[::-1]
    assert "next" not in following.links


def test_a_listing_that_has_not_changed_is_not_sent_again(client: TestClient, submit: Callable[..., str]) -> None:
    job = submit(tags=["kept"])
    first = client.get("/api/v1/jobs", params={"tag": "kept"})

    def again() -> Any:
        return client.get("/api/v1/jobs", params={"tag": "kept"}, headers={"If-None-Match": first.headers["ETag"]})

    answer = again()
    assert (answer.status_code, answer.content, answer.headers["ETag"]) == (304, b"", first.headers["ETag"])
    client.patch(f"/api/v1/jobs/{job}", json={"name": "other"}).raise_for_status()
    assert again().json()["items"][0]["name"] == "other"


# Ends


def test_a_job_that_waits_is_cancelled_at_once(client: TestClient, submit: Callable[..., str]) -> None:
    job = submit()
    answer = client.post(f"/api/v1/jobs/{job}/cancel")
    assert answer.status_code == 202
    assert answer.json()["state"] == "cancelled"
    assert answer.json()["finished_at"] is not None
    assert "it is cancelled" in problem(client.post(f"/api/v1/jobs/{job}/cancel"), 409)
    assert problem(client.get(f"/api/v1/jobs/{job}/image.exr"), 404)


def test_a_cancelled_job_is_tried_again_by_another(client: TestClient, submit: Callable[..., str]) -> None:
    job = submit(name="a", tags=["t"], priority=2)
    assert "Only one that failed or was cancelled" in problem(client.post(f"/api/v1/jobs/{job}/retry"), 409)
    client.post(f"/api/v1/jobs/{job}/cancel").raise_for_status()
    answer = client.post(f"/api/v1/jobs/{job}/retry")
    assert answer.status_code == 201
    made = answer.json()
    assert answer.headers["Location"] == f"/api/v1/jobs/{made['id']}"
    assert (made["state"], made["retry_of"], made["id"] != job) == ("queued", job, True)
    before = client.get(f"/api/v1/jobs/{job}").json()
    same = ("name", "tags", "priority", "scene", "device", "reference")
    assert {key: made[key] for key in same} == {key: before[key] for key in same}
    assert before["state"] == "cancelled"


def test_a_job_that_has_ended_is_deleted(client: TestClient, submit: Callable[..., str], data: Path) -> None:
    job = submit(tags=["t"])
    assert "Cancel it first" in problem(client.delete(f"/api/v1/jobs/{job}"), 409)
    client.post(f"/api/v1/jobs/{job}/cancel").raise_for_status()
    (data / "jobs" / job).mkdir()
    (data / "jobs" / job / "preview.png").write_bytes(b"")
    assert client.delete(f"/api/v1/jobs/{job}").status_code == 204
    assert not (data / "jobs" / job).exists()
    for method, path in (("GET", ""), ("DELETE", ""), ("PATCH", ""), ("POST", "/cancel"), ("POST", "/retry")):
        body = {"json": {"tags": ["t"]}} if method == "PATCH" else {}
        assert "There is no job" in problem(client.request(method, f"/api/v1/jobs/{job}{path}", **body), 404)


def test_some_jobs_are_deleted_at_once(client: TestClient, submit: Callable[..., str]) -> None:
    """Each that can be; of the others it is said why not."""
    ended, other, waits = submit(), submit(), submit()
    for job in (ended, other):
        client.post(f"/api/v1/jobs/{job}/cancel").raise_for_status()
    answer = client.post("/api/v1/jobs/delete", json={"ids": [ended, "nobody", waits, other]})
    assert answer.raise_for_status().json() == {
        "deleted": [ended, "nobody", other],
        "kept": {waits: f"Job {waits} is queued. Cancel it first."},
    }
    assert [client.get(f"/api/v1/jobs/{job}").status_code for job in (ended, waits, other)] == [404, 200, 404]
    for ids in ([], ["x"] * 1001, ["\0"], 7):
        assert problem(client.post("/api/v1/jobs/delete", json={"ids": ids}), 422)


def test_variants_stay_with_their_comparison(client: TestClient, make_scene: MakeScene) -> None:
    body = {"scene": make_scene(), "vary": {"integrator": ["volumetric_path", "transmittance"]}, "seconds": 1}
    answer = client.post("/api/v1/comparisons", json=body)
    assert answer.status_code == 201, answer.text
    job = answer.json()["jobs"][0]["id"]
    client.post(f"/api/v1/jobs/{job}/cancel").raise_for_status()
    assert "is a variant of the comparison" in problem(client.delete(f"/api/v1/jobs/{job}"), 409)


# While a job is rendered


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    service = Service(tmp_path_factory.mktemp("service"), WOODCOCK_LEASE_SECONDS="2")
    service.start()
    yield service
    if service.process is not None:
        service.stop()


def rendered(job: dict[str, Any]) -> bool:
    return bool(job["samples"])


def test_a_job_that_is_rendered_is_cancelled(service: Service, make_scene: MakeScene) -> None:
    """Its checkpoints go, its preview stays, and the next job is rendered; whoever follows it learns the end."""
    job = service.submit(make_scene(64, 1 << 22))
    service.wait(job, rendered)
    answer = service.http.post(f"/api/v1/jobs/{job}/cancel")
    assert (answer.status_code, answer.json()["state"]) == (202, "cancelling")
    end = service.wait(job, lambda now: now["state"] != "cancelling", 5)
    assert end["state"] == "cancelled"
    assert {path.name for path in (service.data / "jobs" / job).iterdir()} == {"preview.png", "thumbnail.webp"}
    assert service.http.get(end["links"]["preview"]).status_code == 200
    with service.http.stream("GET", end["links"]["events"]) as events:
        assert "event: end" in "".join(events.iter_text())
    after = service.submit(make_scene())
    assert service.wait(after, lambda now: now["state"] == "succeeded")
    service.http.delete(f"/api/v1/jobs/{job}").raise_for_status()
    assert not (service.data / "jobs" / job).exists()


def test_the_higher_priority_is_rendered_first(service: Service, make_scene: MakeScene) -> None:
    held = service.submit(make_scene(64, 1 << 22))
    service.wait(held, rendered)
    low, high = service.submit(make_scene()), service.submit(make_scene(), priority=1)
    service.http.post(f"/api/v1/jobs/{held}/cancel").raise_for_status()
    first, second = (service.wait(job, lambda now: now["state"] == "succeeded") for job in (high, low))
    assert first["started_at"] < second["started_at"]


def test_a_job_whose_holder_dies_is_cancelled_all_the_same(service: Service, make_scene: MakeScene) -> None:
    """And the folder of a job that was deleted while the server died is gone."""
    job = service.submit(make_scene(64, 1 << 22))
    service.wait(job, rendered)
    service.stop(signal.SIGKILL)
    (service.data / "jobs" / "no-job").mkdir()
    service.start()
    service.http.post(f"/api/v1/jobs/{job}/cancel").raise_for_status()
    assert service.wait(job, lambda now: now["state"] == "cancelled", 10)
    assert not (service.data / "jobs" / "no-job").exists()
