"""What becomes of a batch: cancelled, deleted, tried again, rendered, extended."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from subprocess import run
from typing import Any

import pytest
from sqlalchemy import update
from starlette.testclient import TestClient

from woodcock.image import read_exr
from woodcock_server import tables
from woodcock_server.identifiers import new_id
from woodcock_server.jobs import repository
from woodcock_server.jobs import service as jobs

from .conftest import Service
from .files import OPEN
from .sweeps import PATH, Sweep, made, problem, services

MakeScene = Callable[..., dict[str, Any]]


def test_all_that_has_not_ended_is_cancelled(client: TestClient, sweep: Sweep) -> None:
    batch, other = made(sweep()), made(sweep())
    first, second, *_ = (job["id"] for job in batch["jobs"])
    client.post(f"/api/v1/jobs/{first}/cancel").raise_for_status()
    moment = client.get(f"/api/v1/jobs/{first}").json()["finished_at"]
    engine, now = services(client).engine, datetime.now(UTC)
    with engine.begin() as connection:
        assert repository.claim(connection, second, "somebody", now, timedelta(minutes=1))
    path = f"{batch['links']['self']}/cancel"
    answer = client.post(path)
    assert answer.status_code == 202
    assert answer.json() == client.get(batch["links"]["self"]).json()
    assert [job["state"] for job in answer.json()["jobs"]] == ["cancelled", "cancelling", "cancelled", "cancelled"]
    assert client.get(f"/api/v1/jobs/{first}").json()["finished_at"] == moment
    assert client.get(other["links"]["self"]).json()["counts"]["queued"] == 4
    assert client.post(path).status_code == 202, "one of them has not ended yet"
    with engine.begin() as connection:
        assert repository.let_go(connection, second, 1, now)
    assert "All jobs of batch" in problem(client.post(path), 409)


def test_a_batch_that_has_ended_is_deleted(client: TestClient, sweep: Sweep, data: Path) -> None:
    """With what was tried again; not while somebody holds a picture against one of its."""
    batch, other = made(sweep(tags=["gone"])), made(sweep())
    path, ids = batch["links"]["self"], [job["id"] for job in batch["jobs"]]
    client.post(f"/api/v1/jobs/{ids[0]}/cancel").raise_for_status()
    assert "that have not ended: 3. Cancel it first." in problem(client.delete(path), 409)
    assert len(client.get(path).json()["jobs"]) == 4
    client.post(f"{path}/cancel").raise_for_status()
    for job in ids:
        (data / "jobs" / job).mkdir()
    user = other["jobs"][0]["id"]
    with services(client).engine.begin() as connection:
        connection.execute(update(tables.jobs).where(tables.jobs.c.id == user).values(reference=ids[2]))
    assert "held against pictures of batch" in problem(client.delete(path), 409)
    assert (data / "jobs" / ids[0]).exists()
    client.post(f"/api/v1/jobs/{user}/cancel").raise_for_status()
    assert client.delete(path).status_code == 204
    assert problem(client.get(path), 404)
    assert not any((data / "jobs" / job).exists() for job in ids)
    assert client.get("/api/v1/jobs", params={"tag": "gone"}).json()["items"] == []
    assert len(client.get(other["links"]["self"]).json()["jobs"]) == 4


def test_a_job_of_a_batch_is_deleted_and_tried_again_alone(client: TestClient, sweep: Sweep) -> None:
    batch = made(sweep())
    path, ids = batch["links"]["self"], [job["id"] for job in batch["jobs"]]
    client.post(f"{path}/cancel").raise_for_status()
    again = made(client.post(f"/api/v1/jobs/{ids[1]}/retry"))
    assert (again["batch"], again["point"]) == (batch["id"], batch["jobs"][1]["point"])
    assert client.delete(f"/api/v1/jobs/{ids[0]}").status_code == 204
    found = client.get(path).json()
    assert [job["id"] for job in found["jobs"]] == [*ids[1:], again["id"]]
    assert found["jobs"][-1]["retry_of"] == ids[1]
    assert (found["counts"]["queued"], found["counts"]["cancelled"]) == (1, 3)
    for job in ids[1:]:
        client.delete(f"/api/v1/jobs/{job}").raise_for_status()
    assert "that have not ended: 1." in problem(client.delete(path), 409)
    client.post(f"{path}/cancel").raise_for_status()
    client.delete(f"/api/v1/jobs/{again['id']}").raise_for_status()
    assert problem(client.get(path), 404), "with the last of its jobs"
    assert problem(client.delete(path), 404)


def test_nothing_follows_from_what_went_with_its_batch(
    client: TestClient, sweep: Sweep, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever asked just before it went is told that it has gone."""
    batch = made(sweep())
    client.post(f"{batch['links']['self']}/cancel").raise_for_status()

    def late() -> str:
        client.delete(batch["links"]["self"])
        return new_id()

    monkeypatch.setattr(jobs, "new_id", late)
    assert problem(client.post(f"/api/v1/jobs/{batch['jobs'][0]['id']}/retry"), 404)
    assert client.get("/api/v1/jobs", params={"batch": batch["id"]}).json()["items"] == []


# Rendered


def wait(service: Service, path: str, jobs: int) -> dict[str, Any]:
    """The batch, once so many of its jobs have succeeded."""
    end = time.monotonic() + 100
    while (now := service.http.get(path).raise_for_status().json())["counts"]["succeeded"] < jobs:
        assert time.monotonic() < end, f"{now}\n{service.log.read_text()}"
        assert not now["counts"]["failed"], f"{now}\n{service.log.read_text()}"
        time.sleep(0.1)
    return dict(now)


def light(service: Service, folder: Path, job: dict[str, Any]) -> float:
    """The mean of a picture."""
    path = folder / "image.exr"
    path.write_bytes(service.http.get(job["links"]["image"]).raise_for_status().content)
    return float(read_exr(path)[0]["Y"].mean())


def test_each_point_is_rendered(service: Service, make_scene: MakeScene, tmp_path: Path) -> None:
    """The denser the cube the darker, whatever the seed. What goes on from a picture is where that is."""
    scene = make_scene(samples=16)
    scene["volumes"][0]["albedo"] = 0.5
    product = {"volumes[0].sigma_t": [0.2, 5], "seed": [1, 2]}
    path = made(service.http.post(PATH, json={"scene": scene, "product": product}))["links"]["self"]
    batch = wait(service, path, 4)
    thin, again, dense, more = (light(service, tmp_path, job) for job in batch["jobs"])
    assert max(dense, more) < 0.9 * min(thin, again)
    assert thin != again
    assert {(job["samples"], job["fraction"]) for job in batch["jobs"]} == {(16, 1)}
    last = batch["jobs"][-1]
    stop = {"stop": {"kind": "samples", "samples": 24}}
    extended = made(service.http.post(f"{last['links']['self']}/extend", json=stop))
    assert (extended["batch"], extended["point"]) == (batch["id"], last["point"])
    batch = wait(service, path, 5)
    assert [(job["extends"], job["samples"]) for job in batch["jobs"][3:]] == [(None, 16), (last["id"], 24)]


def test_what_is_extended_leaves_a_sweep_of_the_contract(service: Service, make_scene: MakeScene) -> None:
    path = made(service.http.post(PATH, json={"scene": make_scene(), "zip": {"stop.samples": [8]}}))["links"]["self"]
    (job,) = wait(service, path, 1)["jobs"]
    stop = {"stop": {"kind": "samples", "samples": 9}}
    extended = made(service.http.post(f"{job['links']['self']}/extend", json=stop))
    assert (extended["batch"], extended["point"], extended["extends"]) == (None, None, job["id"])
    service.wait(extended["id"], lambda now: now["state"] == "succeeded")
    assert service.http.delete(path).status_code == 204
    assert service.job(extended["id"])["state"] == "succeeded"


@pytest.mark.slow
def test_the_command_shows_what_became_of_each(service: Service, make_scene: MakeScene, tmp_path: Path) -> None:
    """Files among the values are uploaded; of what fails it says why, and how many."""
    scene, address = make_scene(), str(service.http.base_url).rstrip("/")
    (tmp_path / "cube.json").write_text(json.dumps(scene))
    (tmp_path / "open.obj").write_bytes(OPEN)
    shapes = f"{json.dumps(scene['volumes'][0]['shape'])},{json.dumps({'kind': 'mesh', 'file': 'open.obj'})}"
    command = [sys.executable, "-m", "woodcock_client.cli", "submit", "cube.json", "--server", address]
    asked = ["--zip", f"volumes[0].shape={shapes}", "--zip", "seed=1,2", "--sweep", "camera.fov=35", "--follow"]
    done = run([*command, *asked], cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False)
    page, *table = filter(None, done.stdout.splitlines())
    batch = service.http.get(f"{PATH}/{page.removeprefix(f'{address}/batches/')}").json()
    assert [axis["paths"] for axis in batch["axes"]] == [["volumes[0].shape", "seed"], ["camera.fov"]]
    assert batch["axes"][0]["rows"][1][0]["file"].startswith("sha256:")
    assert [job["state"] for job in batch["jobs"]] == ["succeeded", "failed"]
    assert all(any(job["id"] in line and job["state"] in line for line in table) for job in batch["jobs"])
    *_, last, sentence = done.stderr.splitlines()
    assert last == "100%, 2 of 2 done, 1 failed"
    assert sentence.startswith("woodcock: 1 of 2 renders did not succeed: ")
    assert sentence.endswith(batch["jobs"][1]["error"].splitlines()[0])
    assert done.returncode == 1
