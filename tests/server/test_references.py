"""What a job may be held against, and what is said of what it may not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sqlalchemy import update
from starlette.testclient import TestClient

from woodcock.film import Film
from woodcock.image import write_exr
from woodcock_server.jobs import reference
from woodcock_server.jobs.states import State
from woodcock_server.tables import jobs

Make = Callable[..., dict[str, Any]]


def picture(path: Path, width: int = 16, height: int = 16, value: float = 0.5) -> Path:
    values = np.full((height, width, 1), value)
    write_exr(path, Film(np.full((height, width), 9, np.uint32), values, values, ("Y",), ((0, 9),)), {})
    return path


def upload(client: TestClient, path: Path) -> str:
    return str(client.post(f"/api/v1/volumes?name={path.name}", content=path.read_bytes()).json()["id"])


def submit(client: TestClient, scene: dict[str, Any], named: str | None) -> Any:
    return client.post("/api/v1/jobs", json={"scene": scene, "reference": named})


def fault(answer: Any) -> str:
    assert (answer.status_code, answer.headers["content-type"]) == (422, "application/problem+json")
    ((field, message),) = [(error["field"], error["message"]) for error in answer.json()["errors"]]
    assert field == "reference"
    return str(message)


def job(client: TestClient, scene: dict[str, Any], state: State, value: float = 0.5) -> str:
    """A job in this state, whose picture is there."""
    services: Any = client.app.state.services  # type: ignore[attr-defined]
    job_id = str(submit(client, scene, None).json()["id"])
    with services.engine.begin() as connection:
        connection.execute(update(jobs).where(jobs.c.id == job_id).values(state=state))
    services.storage.open_job(job_id)
    film = scene["film"]
    picture(services.storage.job_file(job_id, "image.exr"), film["width"], film["height"], value)
    return job_id


def test_a_job_names_a_picture_that_was_uploaded(client: TestClient, make_scene: Make, tmp_path: Path) -> None:
    named = upload(client, picture(tmp_path / "right.exr"))
    answer = submit(client, make_scene(), named)
    assert answer.status_code == 201
    shown = answer.json()
    assert shown["reference"] == named
    assert shown["id"] in [
        each["id"] for each in client.get("/api/v1/jobs").json()["items"] if each["reference"] == named
    ]
    assert submit(client, make_scene(), None).json()["reference"] is None
    loaded = reference.load(client.app.state.services.storage, named)  # type: ignore[attr-defined]
    assert (loaded.name, float(loaded.mean.mean())) == (named, 0.5)
    assert loaded.variance is not None, "it is one of ours, and states it"


def test_a_job_names_another_job(client: TestClient, make_scene: Make) -> None:
    named = job(client, make_scene(), State.SUCCEEDED, value=0.25)
    assert submit(client, make_scene(samples=99), named).json()["reference"] == named
    loaded = reference.load(client.app.state.services.storage, named)  # type: ignore[attr-defined]
    assert (loaded.name, float(loaded.mean.mean())) == (named, 0.25)


@pytest.mark.parametrize("state", [State.QUEUED, State.RUNNING, State.FAILED])
def test_a_job_that_has_not_succeeded_is_none(client: TestClient, make_scene: Make, state: State) -> None:
    named = job(client, make_scene(), state)
    assert fault(submit(client, make_scene(), named)) == f"must be a job that has succeeded; {named} is {state}"


@pytest.mark.parametrize("named", ["", "nothing", "01a203ec-60ec-7844-bfb9-e3d5", "../../../etc/passwd", "sha256:0"])
def test_a_job_that_there_is_not_is_none(client: TestClient, make_scene: Make, named: str) -> None:
    says = fault(submit(client, make_scene(), named))
    assert says == "must be the id of a job that has succeeded, or that of an uploaded picture (sha256:…)"


def test_what_was_not_uploaded_or_is_no_picture_is_none(client: TestClient, make_scene: Make, tmp_path: Path) -> None:
    says = fault(submit(client, make_scene(), f"sha256:{'0' * 64}"))
    assert says == "must be the id (sha256:…) of a picture that was uploaded to /api/v1/volumes"
    np.save(tmp_path / "ramp.npy", np.ones((4, 4, 4), np.float32))
    named = upload(client, tmp_path / "ramp.npy")
    assert fault(submit(client, make_scene(), named)) == "must be a picture; ramp.npy is a volume"


def test_another_size_is_told(client: TestClient, make_scene: Make, tmp_path: Path) -> None:
    named = upload(client, picture(tmp_path / "wide.exr", width=32))
    says = "must be 16 × 16 pixels, as the scene's film is; it is 32 × 16"
    assert fault(submit(client, make_scene(), named)) == says
    small = job(client, make_scene(size=8), State.SUCCEEDED)
    assert fault(submit(client, make_scene(), small)).endswith("it is 8 × 8")


def test_a_picture_that_is_nothing_to_hold_against_is_told_without_a_path(
    client: TestClient, make_scene: Make, tmp_path: Path, data: Path
) -> None:
    named = upload(client, picture(tmp_path / "black.exr", value=0))
    says = fault(submit(client, make_scene(), named))
    assert "is black" in says
    assert says.startswith(named)
    gone = job(client, make_scene(), State.SUCCEEDED)
    (data / "jobs" / gone / "image.exr").unlink()
    says = fault(submit(client, make_scene(), gone))
    assert says.startswith(f"jobs/{gone}/image.exr: ")
    assert str(data) not in says
