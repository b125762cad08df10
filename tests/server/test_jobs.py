"""/api/v1/jobs, up to the queue."""

from __future__ import annotations

import sqlite3
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from woodcock import denoise

Make = Callable[..., dict[str, Any]]
RESULTS = ("image.exr", "preview.png", "thumbnail.webp", "report.json", "report.html")


def submit(client: TestClient, scene: dict[str, Any], **more: Any) -> Any:
    return client.post("/api/v1/jobs", json={"scene": scene, **more})


def test_a_submitted_job_is_in_the_database_before_the_answer(client: TestClient, data: Path, make_scene: Make) -> None:
    answer = submit(client, make_scene(), name="cube")
    assert answer.status_code == 201
    job = answer.json()
    assert answer.headers["location"] == f"/api/v1/jobs/{job['id']}" == job["links"]["self"]
    with sqlite3.connect(data / "woodcock.sqlite") as connection:
        assert connection.execute("SELECT state, name FROM jobs WHERE id = ?", (job["id"],)).fetchone() == (
            "queued",
            "cube",
        )
    connection.close()


def test_a_job_says_what_it_is_and_how_far(client: TestClient, make_scene: Make) -> None:
    job = submit(client, make_scene(size=4, samples=9)).json()
    assert client.get(job["links"]["self"]).json() == job
    assert job["created_at"].endswith("Z")
    links = job.pop("links")
    assert links["image"] is links["preview"] is links["report"] is links["report_page"] is None
    assert job["scene"]["seed"] == 0
    expected = {
        "state": "queued", "width": 4, "height": 4, "samples": 0, "fraction": 0, "seconds": 0, "rmse": None,
        "relative_rmse": None, "started_at": None, "finished_at": None, "devices": [], "error": None, "name": "",
        "target": {"kind": "samples", "samples": 9}, "device": "any", "reference": None,
        "waiting": "No OpenCL device is ready; /api/v1/devices says why.",
    }  # fmt: skip
    assert {key: job[key] for key in expected} == expected


def test_a_relative_error_is_as_far_as_its_samples(client: TestClient, data: Path, make_scene: Make) -> None:
    """An error that is to be halved has a quarter of the samples that it needs."""
    job = submit(client, make_scene(stop={"kind": "relative_error", "relative_error": 0.01})).json()
    assert job["fraction"] == 0
    for reached, fraction in ((0.02, 0.25), (0.1, 0.01), (0.01, 1), (0.005, 1), (None, 0), (0, 0)):
        with sqlite3.connect(data / "woodcock.sqlite") as connection:
            connection.execute("UPDATE jobs SET samples = 9, reached = ? WHERE id = ?", (reached, job["id"]))
        connection.close()
        assert client.get(job["links"]["self"]).json()["fraction"] == pytest.approx(fraction)


def test_denoising_is_refused_where_its_extra_is_missing(
    client: TestClient, make_scene: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    denoise._library.cache_clear()
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    answer = submit(client, make_scene(denoise=True))
    denoise._library.cache_clear()
    assert answer.status_code == 422
    (fault,) = answer.json()["errors"]
    assert fault["field"] == "scene.denoise"
    assert "pip install 'woodcock[denoise]'" in fault["message"]


@pytest.mark.parametrize(
    ("change", "field", "says"),
    [
        ({"film": {"width": 0, "height": 4}}, "scene.film.width", "greater than or equal to 1"),
        ({"lights": [{"kind": "constant", "radiance": -1}]}, "scene.lights[0].radiance", "from 0 to 1e30"),
        ({"lights": [{"kind": "lamp"}]}, "scene.lights[0]", "unknown kind"),
        ({"stop": {"kind": "samples", "samples": 1.5}}, "scene.stop.samples", "integer"),
        ({"volumes": []}, "scene", "volumes or surfaces must hold something"),
        ({"colour": "red"}, "scene.colour", "not a known key"),
        (
            {
                "volumes": [
                    {
                        "kind": "constant",
                        "shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]},
                        "sigma_t": -1,
                        "albedo": 1,
                    }
                ]
            },
            "scene.volumes[0].sigma_t",
            "each 0 or more",
        ),
    ],
)
def test_a_fault_of_a_scene_names_its_field(
    client: TestClient, make_scene: Make, change: dict[str, Any], field: str, says: str
) -> None:
    answer = submit(client, make_scene(**change))
    problem = answer.json()
    assert (answer.status_code, answer.headers["content-type"]) == (422, "application/problem+json")
    assert problem["status"] == 422
    assert [error["field"] for error in problem["errors"]] == [field]
    assert says in problem["errors"][0]["message"]


def test_every_fault_is_told_at_once(client: TestClient, make_scene: Make) -> None:
    problem = submit(client, make_scene(seed=-1, lights=[{"kind": "constant"}]), name=7).json()
    assert {error["field"] for error in problem["errors"]} == {"scene.seed", "scene.lights[0].radiance", "name"}
    assert problem["detail"] == "The request has 3 faults."


@pytest.mark.parametrize("body", [b"", b"{", b"[]", b'"scene"', b"\xff\xfe", b"NaN"])
def test_a_body_that_is_no_object_is_a_422(client: TestClient, body: bytes) -> None:
    answer = client.post("/api/v1/jobs", content=body, headers={"content-type": "application/json"})
    assert answer.status_code in (400, 422), answer.text
    assert answer.headers["content-type"] == "application/problem+json"


def test_a_body_that_is_too_large_is_refused_announced_or_not(client: TestClient) -> None:
    large = b" " * (1 << 20) + b"{}"
    for content in (large, iter([large[: 1 << 19], large[1 << 19 :]])):
        answer = client.post("/api/v1/jobs", content=content, headers={"content-type": "application/json"})
        assert (answer.status_code, answer.headers["content-type"]) == (413, "application/problem+json")
        assert "1048576 bytes" in answer.json()["detail"]


def test_a_volume_that_was_not_uploaded_is_named(client: TestClient, make_scene: Make) -> None:
    for file in ("cloud.vdb", "sha256:" + "0" * 64, "/etc/passwd"):
        answer = submit(client, make_scene(volumes=[{"kind": "grid", "file": file, "albedo": 1}]))
        assert answer.status_code == 422
        assert answer.json()["errors"][0]["field"] == "scene.volumes[0].file"


def test_pages_hold_every_job_once_newest_first(client: TestClient, make_scene: Make) -> None:
    for number in range(5):
        submit(client, make_scene(size=2), name=f"page {number}")
    seen, url = [], "/api/v1/jobs?limit=2&state=queued"
    while url:
        answer = client.get(url)
        page = answer.json()
        assert len(page["items"]) <= 2
        seen += page["items"]
        assert bool(page["next"]) == ("link" in answer.headers)
        url = answer.links["next"]["url"] if page["next"] else ""
        submit(client, make_scene(size=2), name="came in meanwhile")
    ids = [job["id"] for job in seen]
    assert ids == sorted(set(ids), reverse=True)
    assert [job["name"] for job in seen][:5] == [f"page {number}" for number in (4, 3, 2, 1, 0)]
    assert "scene" not in seen[0]
    assert client.get("/api/v1/jobs?state=failed").json() == {"items": [], "next": None}


@pytest.mark.parametrize(
    ("query", "field"),
    [("limit=0", "limit"), ("limit=201", "limit"), ("cursor=x", "cursor"), ("state=lost", "state[0]")],
)
def test_a_fault_of_a_query_names_it(client: TestClient, query: str, field: str) -> None:
    answer = client.get(f"/api/v1/jobs?{query}")
    assert answer.status_code == 422
    assert [error["field"] for error in answer.json()["errors"]] == [field]


@pytest.mark.parametrize(
    "path",
    [
        *(f"/api/v1/jobs/nothing{rest}" for rest in ("", "/events", *(f"/{name}" for name in RESULTS))),
        "/api/v1/volumes/sha256:0",
        "/api/v1/nothing",
        "/nothing",
    ],
)
def test_what_is_not_there_is_a_404(client: TestClient, path: str) -> None:
    answer = client.get(path)
    assert (answer.status_code, answer.headers["content-type"]) == (404, "application/problem+json")


def test_results_that_are_not_there_yet_say_so(client: TestClient, make_scene: Make) -> None:
    job = submit(client, make_scene()).json()
    for name in RESULTS:
        answer = client.get(f"/api/v1/jobs/{job['id']}/{name}")
        assert answer.status_code == 404
        assert answer.json()["detail"] == f"Job {job['id']} has no {name}: it is queued."


def test_a_wrong_method_is_a_problem_too(client: TestClient) -> None:
    answer = client.delete("/api/v1/jobs")
    assert (answer.status_code, answer.headers["content-type"]) == (405, "application/problem+json")
