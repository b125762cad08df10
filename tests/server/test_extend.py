"""A picture that is done is gone on from: the old one stays, and no sample is rendered twice."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from woodcock.image import read_exr

from .conftest import Service

MakeScene = Callable[..., dict[str, Any]]


def ended(job: dict[str, Any]) -> bool:
    return bool(job["finished_at"])


def picture(service: Service, folder: Path, job: str) -> dict[str, Any]:
    path = folder / f"{job}.exr"
    path.write_bytes(service.http.get(f"/api/v1/jobs/{job}/image.exr").raise_for_status().content)
    return read_exr(path)[0]


def test_more_samples_for_a_picture(service: Service, tmp_path: Path, make_scene: MakeScene) -> None:
    first = service.submit(make_scene(samples=40), "cpu0", name="a", tags=["x"], priority=2)
    old = service.wait(first, ended)
    before = picture(service, tmp_path, first)
    asked = {"json": {"stop": {"kind": "samples", "samples": 100}}, "headers": {"Idempotency-Key": first}}
    answer = service.http.post(f"/api/v1/jobs/{first}/extend", **asked)
    assert answer.status_code == 201, answer.text
    made = answer.json()
    assert service.http.post(f"/api/v1/jobs/{first}/extend", **asked).json() == made, (
        "one job, however often it is asked"
    )
    assert answer.headers["location"] == made["links"]["self"]
    assert (made["extends"], made["name"], made["tags"], made["priority"], made["device"]) == (
        first,
        "a",
        ["x"],
        2,
        "cpu0",
    )
    assert made["scene"]["stop"]["samples"] == 100
    assert made["samples"] >= 40
    assert service.http.get(made["links"]["preview"]).status_code == 200
    inherited = service.http.get(
        made["links"]["thumbnail"], params={"samples": made["samples"], "state": made["state"]}
    )
    assert (inherited.content[8:12], inherited.headers["Cache-Control"]) == (b"WEBP", "no-cache")
    end = service.wait(made["id"], ended)
    assert (end["state"], end["samples"]) == ("succeeded", 100)
    assert end["seconds"] > old["seconds"]
    assert end["rmse"] < old["rmse"]
    report = service.http.get(end["links"]["report"]).json()
    assert report["sample_ranges"] == [[0, 100]]
    assert sum(use["samples"] for use in report["devices"]) == 100

    # As of one that was never interrupted; the old one is what it was.
    whole = service.submit(make_scene(samples=100), "cpu0")
    service.wait(whole, ended)
    extended, right = (picture(service, tmp_path, job) for job in (made["id"], whole))
    assert extended.keys() == right.keys()
    for name, values in right.items():
        assert np.allclose(extended[name], values, rtol=1e-5, atol=1e-9), name
    again = picture(service, tmp_path, first)
    assert all(np.array_equal(again[name], values) for name, values in before.items())

    # Once more, from the second; deleting what it came from takes nothing from it.
    third = service.http.post(
        f"/api/v1/jobs/{made['id']}/extend", json={"stop": {"kind": "samples", "samples": 120}}
    ).json()
    assert service.http.delete(f"/api/v1/jobs/{first}").status_code == 204
    assert service.http.delete(f"/api/v1/jobs/{made['id']}").status_code == 204
    assert service.wait(third["id"], ended)["samples"] == 120


def test_what_cannot_be_gone_on_from(service: Service, make_scene: MakeScene) -> None:
    job = service.submit(make_scene(samples=8))
    path = f"/api/v1/jobs/{job}/extend"
    service.wait(job, ended)
    for stop, field, says in (
        ({"kind": "samples", "samples": 8}, "stop.samples", "must be more than 8"),
        ({"kind": "seconds", "seconds": 90}, "stop.kind", "must be `samples`, as it was"),
        ({"kind": "samples", "samples": 0}, "stop.samples", "greater than or equal to 1"),
    ):
        answer = service.http.post(path, json={"stop": stop})
        assert answer.status_code == 422
        (fault,) = answer.json()["errors"]
        assert fault["field"] == field
        assert says in fault["message"]
    for film in (service.data / "jobs" / job).glob("film-*"):
        film.unlink()
    answer = service.http.post(path, json={"stop": {"kind": "samples", "samples": 9}})
    assert answer.status_code == 409
    assert "has no samples to go on from" in answer.json()["detail"]
    waiting = service.submit(make_scene(size=64, samples=100000))
    answer = service.http.post(f"/api/v1/jobs/{waiting}/extend", json={"stop": {"kind": "samples", "samples": 200000}})
    assert answer.status_code == 409
    service.http.post(f"/api/v1/jobs/{waiting}/cancel")
