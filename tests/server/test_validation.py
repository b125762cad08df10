"""POST /api/v1/jobs/validate, and the examples that the gallery starts from."""

from __future__ import annotations

from typing import Any

from starlette.testclient import TestClient

from woodcock_server.gallery.examples import FOLDER

from .files import CUBE

VALIDATE, JOBS = "/api/v1/jobs/validate", "/api/v1/jobs"


def jobs(client: TestClient) -> int:
    return len(client.get(JOBS).json()["items"])


def test_what_would_be_taken_is_not_queued(client: TestClient, make_scene: Any) -> None:
    before = jobs(client)
    answer = client.post(VALIDATE, json={"scene": make_scene(), "name": "a", "tags": ["b"]})
    assert (answer.status_code, answer.content) == (204, b"")
    assert jobs(client) == before


def test_it_refuses_what_submitting_refuses(client: TestClient, make_scene: Any) -> None:
    mesh = client.post("/api/v1/volumes?name=cube.obj", content=CUBE).json()["id"]
    grid = {"kind": "grid", "albedo": 0.5}
    faulty: list[tuple[dict[str, Any], str]] = [
        ({"scene": make_scene(volumes=[])}, "scene"),
        ({"scene": make_scene(film={"width": 0})}, "scene.film.width"),
        ({"scene": make_scene(volumes=[{**make_scene()["volumes"][0], "sigma_t": -1}])}, "scene.volumes[0].sigma_t"),
        ({"scene": make_scene(lights=[{"kind": "candle"}])}, "scene.lights[0]"),
        ({"scene": make_scene(volumes=[{**grid, "file": "cloud.vdb"}])}, "scene.volumes[0].file"),
        ({"scene": make_scene(volumes=[{**grid, "file": mesh}])}, "scene.volumes[0].file"),
        ({"scene": make_scene(), "device": "gpu7"}, "device"),
        ({"scene": make_scene(), "tags": [""]}, "tags[0]"),
        ({"scene": make_scene(), "reference": "none"}, "reference"),
    ]
    before = jobs(client)
    for request, field in faulty:
        answer, submitted = client.post(VALIDATE, json=request), client.post(JOBS, json=request)
        assert (answer.status_code, answer.json()) == (422, submitted.json()), request
        assert [fault["field"] for fault in answer.json()["errors"]] == [field]
    assert jobs(client) == before


def test_every_example_can_be_had_with_its_files(client: TestClient) -> None:
    examples = client.get("/api/v1/examples").json()["items"]
    assert {example["name"] for example in examples} == {path.stem for path in FOLDER.glob("*.json")}
    for example in examples:
        answer = client.post(VALIDATE, json={"scene": example["scene"]})
        faults = answer.json()["errors"] if answer.status_code == 422 else []
        assert {fault["field"].rpartition(".")[2] for fault in faults} == ({"file"} if example["files"] else set())
        for address in (*example["files"].values(), example["picture"]):
            assert client.get(address).status_code == 200, address
    assert {name for example in examples for name in example["files"]} == {"fireball.vdb"}
