"""Comparisons: a job for each variant, all or none, and the verdict once they have ended."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient

from woodcock.film import Film
from woodcock.image import write_exr
from woodcock_server.comparisons.service import film_of

from .conftest import Service

Make = Callable[..., dict[str, Any]]
PATH = "/api/v1/comparisons"


def upload(client: Any, path: Path) -> str:
    """A grid of noise."""
    np.save(path, np.random.default_rng(0).random((12, 12, 12), np.float32))
    return str(client.post(f"/api/v1/volumes?name={path.name}", content=path.read_bytes()).json()["id"])


def cloud(client: Any, make_scene: Make, path: Path, **more: Any) -> dict[str, Any]:
    volume = {"kind": "grid", "file": upload(client, path / "cloud.npy"), "scale": 6, "albedo": 0.9}
    return make_scene(volumes=[volume], **more)


def test_a_comparison_is_a_job_for_each_variant(client: TestClient, make_scene: Make, tmp_path: Path) -> None:
    scene = cloud(client, make_scene, tmp_path, seed=(1 << 32) - 1)
    vary = {"majorant": ["global", "grid"], "transmittance": ["ratio", "ray_marching"]}
    answer = client.post(PATH, json={"scene": scene, "vary": vary, "seconds": 2, "name": "cloud"})
    assert answer.status_code == 201, answer.text
    made = answer.json()
    assert answer.headers["location"] == made["links"]["self"] == f"{PATH}/{made['id']}"
    assert client.get(made["links"]["self"]).json() == made
    assert (made["state"], made["seconds"], made["vary"], made["device"]) == ("queued", 2, vary, "any")
    assert (made["rows"], made["verdict"], made["links"]["report"]) == (None, None, None)
    assert [job["label"] for job in made["jobs"]] == [
        "global, ratio", "global, ray_marching", "grid, ratio", "grid, ray_marching",
    ]  # fmt: skip
    jobs = [client.get(job["link"]).json() for job in made["jobs"]]
    assert [job["name"] for job in jobs] == [f"cloud: {job['label']}" for job in made["jobs"]]
    assert {tuple(job["target"].items()) for job in jobs} == {(("kind", "seconds"), ("seconds", 2.0))}
    assert [job["scene"]["majorant"]["kind"] for job in jobs] == ["global", "global", "grid", "grid"]
    assert [job["scene"]["transmittance"]["kind"] for job in jobs] == ["ratio", "ray_marching"] * 2
    assert [job["scene"]["seed"] for job in jobs] == [(1 << 32) - 1, 0, 1, 2], "errors are independent"
    queued = [job["id"] for job in client.get("/api/v1/jobs").json()["items"]]
    assert queued[:4] == [job["id"] for job in reversed(made["jobs"])], "in their order"
    page = client.get(f"{PATH}/{made['id']}/report.html")
    assert (page.status_code, page.json()["detail"].endswith("it is queued.")) == (404, True)


@pytest.mark.parametrize(
    ("body", "field", "says"),
    [
        ({"vary": {"colour": ["red", "blue"]}}, "vary", "colour cannot vary; what can is "),
        ({"vary": {"majorant": ["global", "octree"]}}, "vary", "majorant has no kind octree; it has global, grid"),
        ({"vary": {"majorant": ["grid"]}}, "vary", "a comparison takes 2 to "),
        (
            {
                "vary": {
                    "majorant": ["global", "grid"],
                    "transmittance": ["ratio", "residual_ratio", "ray_marching"],
                    "free_flight": ["delta", "decomposition"],
                    "integrator": ["volumetric_path", "transmittance"],
                }
            },
            "vary",
            "must make 16 variants at most; this makes 24",
        ),
        ({"vary": {}}, "vary", ""),
        ({"seconds": 0}, "seconds", ""),
        ({"device": "cpu7"}, "device", "must be any, or the kind or id of a device of this server"),
        ({"reference": "nobody"}, "reference", "must be the id of a job that has succeeded"),
        ({"scene": {}}, "scene.camera", ""),
    ],
)
def test_what_cannot_be_compared(
    client: TestClient, make_scene: Make, body: dict[str, Any], field: str, says: str
) -> None:
    before = client.get("/api/v1/jobs").json()["items"]
    asked = {"scene": make_scene(), "vary": {"majorant": ["global", "grid"]}, "seconds": 1, **body}
    answer = client.post(PATH, json=asked)
    assert (answer.status_code, answer.headers["content-type"]) == (422, "application/problem+json")
    assert answer.json()["errors"][0]["field"] == field
    assert answer.json()["errors"][0]["message"].startswith(says)
    assert client.get("/api/v1/jobs").json()["items"] == before, "all or none"


def test_a_comparison_that_there_is_not(client: TestClient) -> None:
    for path in (f"{PATH}/nobody", f"{PATH}/nobody/report.html"):
        answer = client.get(path)
        assert (answer.status_code, answer.json()["detail"]) == (404, "There is no comparison nobody.")


def test_a_film_is_what_its_picture_says(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    shape = (5, 7, 3)
    mean, m2 = 1 + rng.random(shape), 40 * rng.random(shape)
    film = Film(np.full((5, 7), 20, np.uint32), mean, m2, ("R", "G", "B"), ((0, 20),))
    write_exr(tmp_path / "image.exr", film, {})
    found = film_of(tmp_path / "image.exr", {"samples": 20, "bound": None})
    assert found.rmse() == pytest.approx(film.rmse(), rel=1e-6)
    assert np.allclose(found.m2, film.m2, rtol=1e-6)
    bounded = film_of(tmp_path / "image.exr", {"samples": 20, "bound": {"largest": 0.25}})
    assert bounded.deterministic
    assert bounded.rmse() == 0.25


def ended(service: Service, made: dict[str, Any], seconds: float = 120) -> dict[str, Any]:
    end = time.monotonic() + seconds
    while True:
        now: dict[str, Any] = service.http.get(made["links"]["self"]).raise_for_status().json()
        if now["state"] in ("succeeded", "failed"):
            return now
        assert time.monotonic() < end, f"{now}\n{service.log.read_text()}"
        time.sleep(0.1)


def test_the_verdict_comes_with_the_last_job(service: Service, make_scene: Make, tmp_path: Path) -> None:
    scene = cloud(service.http, make_scene, tmp_path, size=24)
    body = {"scene": scene, "vary": {"majorant": ["global", "grid"]}, "seconds": 1, "name": "<cloud>"}
    answer = service.http.post(PATH, json=body)
    assert answer.status_code == 201, answer.text
    assert answer.json()["device"] == "cpu0", "one device for all, where it is asked for none"
    now = ended(service, answer.json())
    assert now["state"] == "succeeded", [job["error"] for job in now["jobs"]]
    jobs = [service.job(job["id"]) for job in now["jobs"]]
    assert [job["devices"] for job in jobs] == [["cpu0"], ["cpu0"]]
    assert jobs[0]["finished_at"] <= jobs[1]["started_at"], "one after the other"

    assert [row["label"] for row in now["rows"]] == ["global", "grid"]
    for row, job in zip(now["rows"], jobs, strict=True):
        report = service.http.get(job["links"]["report"]).json()
        assert row["job"] == job["id"]
        assert (row["seconds"], row["samples"]) == (report["seconds"]["render"], report["samples"])
        assert row["rmse"] == pytest.approx(report["rmse"], rel=1e-4)
        # Of all that was rendered up to the last point of the series, in the device's time; pooled over slices, which
        # hold few samples on a busy machine.
        last = report["error"][-1]
        assert row["efficiency"] == pytest.approx(1 / (last["rmse"] ** 2 * last["device_seconds"]), rel=2e-2)
    verdict = now["verdict"]
    assert set(verdict["order"]) == {"global", "grid"}
    assert verdict["disagree"] == []
    best, worst = verdict["order"]
    by_label = {row["label"]: row for row in now["rows"]}
    ratio = by_label[best]["ratio"]
    assert ratio["value"] == pytest.approx(by_label[best]["efficiency"] / by_label[worst]["efficiency"], rel=1e-6)
    assert ratio["low"] <= ratio["value"] <= ratio["high"]
    assert (verdict["winner"] is not None) == (ratio["low"] > 1)

    page = service.http.get(now["links"]["report"])
    assert page.status_code == 200
    assert "not interleaved" in page.text
    assert "&lt;cloud&gt;" in page.text
    assert "<cloud>" not in page.text
    assert "sandbox" in page.headers["content-security-policy"]


def test_variants_that_are_the_same_program_are_not_compared(service: Service, make_scene: Make) -> None:
    body = {"scene": make_scene(), "vary": {"transmittance": ["ratio", "ray_marching"]}, "seconds": 0.2}
    answer = service.http.post(PATH, json=body)
    assert answer.status_code == 201, answer.text
    now = ended(service, answer.json())
    assert now["state"] == "succeeded", [job["error"] for job in now["jobs"]]
    assert len(now["rows"]) == 1
    assert now["verdict"]["same"] == {"ray_marching": "ratio"}
    assert (now["verdict"]["winner"], now["links"]["report"]) == (None, None)
    assert "the same program" in now["verdict"]["says"]
    assert service.http.get(f"{now['links']['self']}/report.html").status_code == 404


def test_a_comparison_of_which_nothing_is_left_has_failed(service: Service, make_scene: Make) -> None:
    data = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"  # no closed mesh
    mesh = service.http.post("/api/v1/volumes?name=thin.obj", content=data).json()["id"]
    volume = {"kind": "constant", "shape": {"kind": "mesh", "file": mesh}, "sigma_t": 1, "albedo": 0.5}
    body = {"scene": make_scene(volumes=[volume]), "vary": {"majorant": ["global", "grid"]}, "seconds": 1}
    now = ended(service, service.http.post(PATH, json=body).json())
    assert (now["state"], now["rows"], now["verdict"]) == ("failed", None, None)
    assert all("closed" in job["error"] or mesh in job["error"] for job in now["jobs"])


def test_the_command_waits_for_the_verdict(service: Service, make_scene: Make, tmp_path: Path) -> None:
    scene = cloud(service.http, make_scene, tmp_path)
    (tmp_path / "cloud.json").write_text(json.dumps(scene))
    command = [sys.executable, "-m", "woodcock_client.cli", "submit", str(tmp_path / "cloud.json")]
    server = ["--server", str(service.http.base_url)]
    more = ["--vary", "majorant=global,grid", "--seconds", "0.3", "--follow"]
    done = subprocess.run([*command, *more, *server], capture_output=True, text=True, timeout=100, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    made, says, page = done.stdout.splitlines()
    assert page == f"{made}/report.html"
    now = service.http.get(made).json()
    assert (now["name"], now["verdict"]["says"]) == ("cloud", says)
    for vary, fault in (("majorant", "write each field once"), ("majorant=grid", "takes 2 to")):
        done = subprocess.run([*command, "--vary", vary, *server], capture_output=True, text=True, check=False)
        assert done.returncode == 2
        assert fault in done.stderr
