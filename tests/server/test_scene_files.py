"""Every file that a scene names: taken in by what it holds, found at fault before the queue, and rendered."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient

from woodcock.image import read_exr
from woodcock.scene import Scene, files
from woodcock_server.volumes.check import parts_with_files

from .conftest import Service
from .files import CUBE, OPEN, exr, fire, npy

Make = Callable[..., dict[str, Any]]
GREY = np.full((4, 8, 3), 0.5)


def uploaded(http: Any, name: str, content: bytes) -> str:
    answer = http.post("/api/v1/volumes", params={"name": name}, content=content)
    assert answer.status_code in (200, 201), answer.text
    return str(answer.json()["id"])


def everything(cube: str, sky: str, flames: str) -> dict[str, Any]:
    """The parts of a scene that names files in every place where it can."""
    emission = {"kind": "blackbody", "file": flames, "kelvin": 2500}
    grid = {"kind": "grid", "file": flames, "albedo": 0.8, "albedo_grid": {"file": flames, "grid": "tint"}}
    return {
        "lights": [{"kind": "constant", "radiance": 0.1}, {"kind": "image", "file": sky}],
        "surfaces": [{"kind": "disk", "radius": 1}, {"kind": "mesh", "file": cube}],
        "volumes": [
            {**grid, "emission": emission},
            {"kind": "constant", "shape": {"kind": "mesh", "file": cube}, "sigma_t": 1, "albedo": 0.5},
            {**grid, "emission": {"kind": "grid", "file": flames, "grid": "temperature"}},
        ],
    }


def faults(client: TestClient, scene: dict[str, Any]) -> dict[str, str]:
    answer = client.post("/api/v1/jobs", json={"scene": scene})
    assert answer.status_code == 422, answer.text
    assert answer.json()["detail"] == "The scene names files that cannot be rendered."
    return {fault["field"]: fault["message"] for fault in answer.json()["errors"]}


# Uploads


def test_an_upload_is_told_by_its_content(client: TestClient) -> None:
    empty = {"grids": [], "triangles": None, "width": None, "height": None}
    for content, found in (
        (CUBE + b"# first\n", {"type": "mesh", "triangles": 12}),
        (exr(2 * GREY), {"type": "picture", "width": 8, "height": 4}),
    ):
        row = client.post("/api/v1/volumes?name=file.bin", content=content).json()
        assert {**row, **empty, **found} == row
    row = client.post("/api/v1/volumes?name=file.bin", content=fire(5)).json()
    assert (row["type"], [grid["name"] for grid in row["grids"]]) == ("volume", ["density", "temperature", "tint"])
    assert {one["type"] for one in client.get("/api/v1/volumes").json()["items"]} == {"mesh", "picture", "volume"}


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"no file at all", r"is no file that can be read; volumes \(OpenVDB.*meshes \(PLY.*pictures \(OpenEXR.* can"),
        (CUBE.replace(b"f 1 4 3 2", b"f 1 4 3 99"), "is no OBJ file that can be read: .*out of bounds.*"),
        (b"v 0 0 0\n", "holds no triangle"),
        (exr(GREY)[:-40], "cannot be read: .*"),
        (b"\x76\x2f\x31\x01", "cannot be read: .*"),
        (b"#?RADIANCE\n\n-Y 4 +X 8\n", "cannot be read: .*"),
        (b'{"asset":{},"buffers":[{"uri":"../woodcock.sqlite"}]}', ".*"),
    ],
)
def test_a_file_that_cannot_be_read_is_refused_in_a_sentence(
    client: TestClient, data: Path, content: bytes, says: str
) -> None:
    answer = client.post("/api/v1/volumes?name=broken", content=content)
    assert answer.status_code == 422
    (fault,) = answer.json()["errors"]
    assert fault["field"] == "body"
    assert re.fullmatch(says, fault["message"]), fault["message"]
    assert answer.json()["detail"] == f"broken: {fault['message']}"
    assert str(data) not in answer.text


# Scenes


def test_every_file_that_a_scene_names_is_looked_at(make_scene: Make) -> None:
    scene = Scene.model_validate(make_scene(**everything("cube", "sky", "flames")))
    found = {path: part.file for path, part in parts_with_files(scene, "scene")}
    assert found == {
        "scene.lights[1]": "sky",
        "scene.surfaces[1]": "cube",
        "scene.volumes[0]": "flames",
        "scene.volumes[0].albedo_grid": "flames",
        "scene.volumes[0].emission": "flames",
        "scene.volumes[1].shape": "cube",
        "scene.volumes[2]": "flames",
        "scene.volumes[2].albedo_grid": "flames",
        "scene.volumes[2].emission": "flames",
    }
    assert set(found.values()) == set(files(scene))


def test_a_scene_may_use_files_of_every_type(client: TestClient, make_scene: Make) -> None:
    ids = (
        uploaded(client, "cube.obj", CUBE),
        uploaded(client, "sky.exr", exr(GREY)),
        uploaded(client, "fire.npz", fire()),
    )
    answer = client.post("/api/v1/jobs", json={"scene": make_scene(**everything(*ids))})
    assert answer.status_code == 201, answer.text


def test_a_file_that_was_not_uploaded_is_named_by_its_field(client: TestClient, make_scene: Make) -> None:
    found = faults(client, make_scene(**everything("cube.obj", "sha256:" + "0" * 64, "/etc/passwd")))
    needs = "must be the id (sha256:…) of a {} that was uploaded to /api/v1/volumes"
    assert found.pop("scene.lights[1].file") == needs.format("picture")
    for field in ("scene.surfaces[1].file", "scene.volumes[1].shape.file"):
        assert found.pop(field) == needs.format("mesh")
    assert set(found.values()) == {needs.format("volume")}
    assert "scene.volumes[0].emission.file" in found
    assert "scene.volumes[0].albedo_grid.file" in found
    assert len(found) == 6


def test_a_file_of_another_type_is_named_by_its_field(client: TestClient, make_scene: Make) -> None:
    flames, cube = uploaded(client, "fire.npz", fire()), uploaded(client, "cube.obj", CUBE)
    sky = uploaded(client, "sky.exr", exr(GREY))
    found = faults(client, make_scene(**everything(flames, cube, sky)))
    assert found["scene.lights[1].file"] == "must be a picture; cube.obj is a mesh"
    assert found["scene.volumes[1].shape.file"] == "must be a mesh; fire.npz is a volume"
    assert found["scene.volumes[0].emission.file"] == "must be a volume; sky.exr is a picture"
    assert len(found) == 9


def test_grids_are_found_by_the_renderers_rules(client: TestClient, make_scene: Make) -> None:
    flames = uploaded(client, "fire.npz", fire())
    dense = uploaded(client, "dense.npy", npy(np.ones((2, 2, 2))))
    none = uploaded(client, "none.npz", fire().replace(b"density", b"smokey1"))
    grid = {"kind": "grid", "file": flames, "albedo": 0.5}
    good = [
        {**grid, "emission": {"kind": "blackbody", "file": flames, "kelvin": 1}},  # `temperature` by itself
        {**grid, "emission": {"kind": "grid", "file": dense}, "albedo_grid": {"file": dense}},  # the only one
    ]
    answer = client.post("/api/v1/jobs", json={"scene": make_scene(volumes=good)})
    assert answer.status_code == 201, answer.text
    found = faults(
        client,
        make_scene(
            volumes=[
                {**grid, "emission": {"kind": "blackbody", "file": dense, "kelvin": 1}},
                {**grid, "emission": {"kind": "grid", "file": flames, "grid": "heat"}},
                {**grid, "albedo_grid": {"file": none}},
                {**grid, "file": none},
            ]
        ),
    )
    several = 'none.npz has no grid "density" and several others: name one of "smokey1", "temperature", "tint"'
    assert found == {
        "scene.volumes[0].emission.grid": 'dense.npy has no grid "temperature"; it has "density"',
        "scene.volumes[1].emission.grid": 'fire.npz has no grid "heat"; it has "density", "temperature", "tint"',
        "scene.volumes[2].albedo_grid.grid": several,
        "scene.volumes[3].grid": several,
    }


def test_an_environment_is_twice_as_wide_as_high(client: TestClient, make_scene: Make) -> None:
    sky = uploaded(client, "square.exr", exr(np.ones((4, 4, 3))))
    assert faults(client, make_scene(lights=[{"kind": "image", "file": sky}])) == {
        "scene.lights[0].file": "square.exr: is 4 × 4 pixels; a picture of all directions is twice as wide as high"
    }


# Renders


def test_a_scene_of_every_type_of_file_is_rendered(service: Service, tmp_path: Path, make_scene: Make) -> None:
    http = service.http
    ids = uploaded(http, "cube.obj", CUBE), uploaded(http, "sky.exr", exr(GREY)), uploaded(http, "fire.npz", fire())
    job_id = service.submit(make_scene(samples=4, **everything(*ids)))
    job = service.wait(job_id, lambda job: bool(job["state"] == "succeeded"))
    assert job["integrator"] == "volumetric_path"
    report = http.get(job["links"]["report"]).raise_for_status().json()
    assert report["kinds"]["light"] == ["constant", "image"]
    (tmp_path / "image.exr").write_bytes(http.get(job["links"]["image"]).content)
    layers, header = read_exr(tmp_path / "image.exr")
    assert np.isfinite(layers["R"]).all()
    assert str(service.data) not in header["scene"], "no path of the server's"


def test_a_job_without_noise_says_so(service: Service, make_scene: Make) -> None:
    cube = {"kind": "constant", "shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]}, "sigma_t": 4, "albedo": 0}
    job_id = service.submit(make_scene(volumes=[cube], samples=4))
    job = service.wait(job_id, lambda job: bool(job["state"] == "succeeded"))
    assert job["integrator"] == "transmittance"
    report = service.http.get(job["links"]["report"]).raise_for_status().json()
    assert (report["deterministic"], report["error"]) == (True, [])
    assert job["rmse"] == report["bound"]["rms"] < 1e-6


@pytest.mark.parametrize(
    ("name", "content", "parts", "says"),
    [
        (
            "open.obj",
            OPEN,
            lambda id: {
                "volumes": [{"kind": "constant", "shape": {"kind": "mesh", "file": id}, "sigma_t": 1, "albedo": 1}]
            },
            "has 4 edges that are not shared by two faces; the shape of a medium must be a closed mesh",
        ),
        (
            "dark.exr",
            exr(-GREY),
            lambda id: {"lights": [{"kind": "image", "file": id}]},
            "holds negative values, down to -0.5; radiance is 0 or more",
        ),
        (
            "cold.npy",
            npy(-np.ones((2, 2, 2))),
            lambda id: {"volumes": [{"kind": "grid", "file": id, "albedo": 1}]},
            "grid 'density' holds negative densities, down to -1, first at voxel (0, 0, 0)",
        ),
    ],
)
def test_a_file_that_cannot_be_used_fails_its_job_with_its_id(
    service: Service, make_scene: Make, name: str, content: bytes, parts: Callable[[str], dict[str, Any]], says: str
) -> None:
    id = uploaded(service.http, name, content)
    job_id = service.submit(make_scene(**parts(id)))
    with pytest.raises(AssertionError):
        service.wait(job_id, lambda job: bool(job["state"] == "succeeded"))
    assert service.job(job_id)["error"] == f"{id}: {says}"
