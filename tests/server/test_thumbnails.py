"""What browsers may keep of a job's pictures: for ever what will never be another one, and nothing else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import update
from starlette.testclient import TestClient

from woodcock_server.tables import jobs

from .sweeps import services

FOR_EVER, FOR_NOW = "private, max-age=31536000, immutable", "no-cache"


@pytest.fixture
def job(client: TestClient, data: Path, make_scene: Callable[..., dict[str, Any]]) -> str:
    """A job of which a dispatcher has written pictures; its id."""
    made = client.post("/api/v1/jobs", json={"scene": make_scene()}).raise_for_status().json()
    assert made["links"]["thumbnail"] is None
    folder = data / "jobs" / made["id"]
    folder.mkdir()
    for name in ("preview.png", "thumbnail.webp"):
        (folder / name).write_bytes(name.encode())
    write(client, made["id"], state="running", samples=7)
    return str(made["id"])


def write(client: TestClient, job: str, **values: Any) -> None:
    with services(client).engine.begin() as connection:
        connection.execute(update(jobs).where(jobs.c.id == job).values(**values))


@pytest.mark.parametrize(("link", "kind"), [("preview", "image/png"), ("thumbnail", "image/webp")])
def test_a_picture_is_kept_once_it_will_never_be_another(client: TestClient, job: str, link: str, kind: str) -> None:
    path = client.get(f"/api/v1/jobs/{job}").json()["links"][link]

    def kept(**version: Any) -> str:
        answer = client.get(path, params=version).raise_for_status()
        assert (answer.text, answer.headers["Content-Type"]) == (path.rpartition("/")[2], kind)
        return str(answer.headers["Cache-Control"])

    # Its samples may be counted before the picture of them is there, and its end may be foretold
    assert kept(samples=7, state="running") == kept(samples=7, state="succeeded") == FOR_NOW
    write(client, job, state="succeeded")
    assert kept(samples=7, state="succeeded") == FOR_EVER
    for other in ({}, {"samples": 7}, {"state": "succeeded"}, {"samples": 6, "state": "succeeded"}):
        assert kept(**other) == FOR_NOW
    assert kept(samples=7, state="running") == FOR_NOW, "as which it was asked for while it ran"
    client.delete(f"/api/v1/jobs/{job}").raise_for_status()
    assert client.get(path, params={"samples": 7, "state": "succeeded"}).status_code == 404


def test_a_job_of_before_thumbnails_shows_its_preview(client: TestClient, data: Path, job: str) -> None:
    (data / "jobs" / job / "thumbnail.webp").unlink()
    links = client.get(f"/api/v1/jobs/{job}").json()["links"]
    answer = client.get(links["thumbnail"], follow_redirects=False)
    assert (answer.status_code, answer.headers["Location"]) == (307, links["preview"])
    assert client.get(links["thumbnail"]).headers["Content-Type"] == "image/png"
    (data / "jobs" / job / "preview.png").unlink()
    assert client.get(links["thumbnail"]).status_code == 404


@pytest.mark.parametrize("query", ["samples=-1", "samples=x", "state=done"])
def test_what_is_no_version(client: TestClient, job: str, query: str) -> None:
    assert client.get(f"/api/v1/jobs/{job}/thumbnail.webp?{query}").status_code == 422
