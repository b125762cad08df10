"""Bad scenes give one clear sentence that names the field; good ones survive the way to JSON and back."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from woodcock.scene import Scene, SceneError, files, load, parse, with_files

GOOD: dict[str, Any] = {
    "camera": {"kind": "perspective", "origin": [0, 0, 5], "target": [0, 0, 0], "fov": 40},
    "volumes": [
        {
            "kind": "grid",
            "file": "cloud.vdb",
            "scale": 3,
            "albedo": [0.9, 0.8, 0.7],
            "phase": {"kind": "henyey_greenstein", "g": 0.5},
        }
    ],
    "lights": [
        {"kind": "constant", "radiance": 1},
        {"kind": "directional", "direction": [0, -1, 0], "irradiance": [1, 2, 3]},
    ],
    "film": {"width": 64, "height": 32},
    "stop": {"kind": "samples", "samples": 8},
}
BOX = {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]}
FLAT = BOX | {"max": [1, 0, 1]}
CONSTANT = {"kind": "constant", "shape": BOX, "sigma_t": 1, "albedo": 0.5}
WARM = {"kind": "blackbody", "kelvin": 800, "file": "heat.vdb"}
TABLE = {"kind": "tabulated", "cosine": [-1, 0, 1], "value": [1, 2, 3]}
SPOT = {"kind": "spot", "position": [0, 0, 0], "target": [0, -1, 0], "intensity": 1}
NAN = float("nan")


def changed(path: str, value: Any) -> str:
    """GOOD with one value changed, as JSON."""
    scene = copy.deepcopy(GOOD)
    *parents, last = path.split(".")
    at: Any = scene
    for part in parents:
        at = at[int(part)] if part.isdigit() else at[part]
    at[int(last) if last.isdigit() else last] = value
    return json.dumps(scene)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (
            "camera.kind",
            "fisheye",
            "camera: unknown kind; known are 'perspective', 'thin_lens', 'orthographic', 'spherical'",
        ),
        ("camera.fov", 180, "camera.fov: input should be less than 180 (got 180)"),
        ("camera.fov", NAN, "camera.fov: input should be a finite number (got NaN)"),
        ("camera.fov", "40", 'camera.fov: input should be a valid number (got "40")'),
        ("camera.origin", [0, 0], "camera.origin[2]: is required"),
        ("camera.target", [0, 0, 5], "camera: target must differ from origin"),
        ("camera.up", [0, 0, 2], "camera: up must not be zero or parallel to the view direction"),
        ("camera.zoom", 2, "camera.zoom: is not a known key (got 2)"),
        ("camera.f o[v]", 2, 'camera["f o[v]"]: is not a known key (got 2)'),
        ("volumes", [], "scene: volumes or surfaces must hold something to render"),
        ("volumes", [CONSTANT] * 9, "volumes: must hold 0 to 8, not 9"),
        ("volumes.0.scale", -1, "volumes[0].scale: must be one number or three (red, green, blue), each 0 or more"),
        ("volumes.0.scale", NAN, "volumes[0].scale: must be one number or three (red, green, blue), each 0 or more"),
        (
            "volumes.0.albedo",
            1.5,
            "volumes[0].albedo: must be one number or three (red, green, blue), each from 0 to 1",
        ),
        ("volumes.0.albedo", [1, 1], "volumes[0].albedo: must be one number or three (red, green, blue), each from 0"),
        (
            "volumes.0.albedo",
            NAN,
            "volumes[0].albedo: must be one number or three (red, green, blue), each from 0 to 1",
        ),
        ("volumes.0.phase.g", 1.1, "volumes[0].phase.g: input should be less than or equal to 1 (got 1.1)"),
        ("volumes.0.phase.g", -1.0, "volumes[0].phase.g: input should be greater than or equal to -0.9999 (got -1.0)"),
        (
            "volumes.0.phase",
            TABLE | {"value": [1, 2]},
            "volumes[0].phase: cosine and value must be equally long, not 3",
        ),
        (
            "volumes.0.phase",
            TABLE | {"cosine": [-1, 0, 0.9]},
            "volumes[0].phase: cosine must begin with -1 and end with 1",
        ),
        (
            "volumes.0.phase",
            TABLE | {"cosine": [-1, 2, 1]},
            "volumes[0].phase: cosine must rise from each entry to the",
        ),
        ("volumes.0.phase", TABLE | {"value": [0, 0, 0]}, "volumes[0].phase: value must exceed 0 somewhere"),
        (
            "volumes.0.phase",
            {"kind": "mixture", "components": []},
            "volumes[0].phase.components: must hold 1 to 8, not 0",
        ),
        ("volumes.0.phase", {"g": 0}, "volumes[0].phase: needs a `kind`"),
        ("volumes.0.file", "", "volumes[0].file: string should have at least 1 character"),
        (
            "volumes.0.to_world",
            [[1, 0, 0, 0], [2, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
            "volumes[0].to_world: must not be singular",
        ),
        (
            "volumes.0.to_world",
            [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]],
            "volumes[0].to_world: the last row must",
        ),
        (
            "volumes.0",
            CONSTANT | {"sigma_t": -2},
            "volumes[0].sigma_t: must be one number or three (red, green, blue), each",
        ),
        ("volumes.0", CONSTANT | {"shape": FLAT}, "volumes[0].shape: max must exceed min along y (min 0, max 0)"),
        (
            "volumes.0",
            CONSTANT | {"emission": WARM},
            "volumes[0]: the emission of a constant volume has one temperature",
        ),
        ("lights.1.direction", [0, 0, 0], "lights[1].direction: must not be zero"),
        ("lights.0", SPOT | {"target": [0, 0, 0]}, "lights[0]: target must differ from position"),
        ("lights.0", SPOT | {"beam": 30}, "lights[0]: beam must be less than the cutoff of 20 degrees"),
        ("surfaces", [{"kind": "disk", "radius": 0}], "surfaces[0].radius: input should be greater than 0 (got 0)"),
        (
            "surfaces",
            [{"kind": "disk", "radius": 1, "material": {"kind": "gold"}}],
            "surfaces[0].material: unknown kind;",
        ),
        ("layers", ["depth", "depth"], "scene: layers must name each layer once"),
        ("orders", -1, "orders: input should be greater than or equal to 0 (got -1)"),
        ("lights.0.radiance", -1, "lights[0].radiance: must be one number or three (red, green, blue), each from 0 to"),
        (
            "lights.0.radiance",
            1e31,
            "lights[0].radiance: must be one number or three (red, green, blue), each from 0 to",
        ),
        ("film.width", 0, "film.width: input should be greater than or equal to 1 (got 0)"),
        ("film.width", 2.5, "film.width: input should be a valid integer"),
        ("film", {"width": 65536, "height": 65536}, "film: width × height must not exceed"),
        ("seed", -1, "seed: input should be greater than or equal to 0 (got -1)"),
        ("stop", {"kind": "samples", "samples": 0}, "stop.samples: input should be greater than or equal to 1 (got 0)"),
        ("stop", {"kind": "seconds", "seconds": 0}, "stop.seconds: input should be greater than 0 (got 0)"),
        ("stop", {"kind": "never"}, "stop: unknown kind; known are 'samples', 'seconds'"),
    ],
)
def test_faults_name_their_field(path: str, value: Any, message: str) -> None:
    with pytest.raises(SceneError) as fault:
        parse(changed(path, value))
    assert str(fault.value).startswith(message)
    assert len(str(fault.value).splitlines()) == 1


def test_every_fault_has_a_line() -> None:
    with pytest.raises(SceneError) as fault:
        parse('{"camera": {"kind": "perspective"}, "volumes": [{"kind": "constant", "sigma_t": -1}]}')
    assert [line.split(":")[0] for line in str(fault.value).splitlines()] == [
        "camera.origin",
        "camera.target",
        "volumes[0].albedo",
        "volumes[0].shape",
        "volumes[0].sigma_t",
    ]


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"a": 1}', "\x00"])
def test_no_scene_at_all(text: str) -> None:
    with pytest.raises(SceneError):
        parse(text)


def test_round_trip_and_schema() -> None:
    scene = parse(json.dumps(GOOD))
    assert parse(scene.model_dump_json()) == scene
    schema = Scene.model_json_schema()
    assert set(schema["properties"]) == set(Scene.model_fields)
    missing = [
        f"{name}.{field}"
        for name, model in schema["$defs"].items()
        for field, described in model["properties"].items()
        if field != "kind" and "description" not in described
    ]
    assert missing == []


def test_files_of_every_kind_are_found() -> None:
    scene = json.loads(json.dumps(GOOD))
    scene["volumes"][0] |= {"albedo_grid": {"file": "albedo.npy"}, "emission": WARM}
    scene["volumes"].append(CONSTANT | {"shape": {"kind": "mesh", "file": "closed.ply"}})
    scene["surfaces"] = [{"kind": "mesh", "file": "bunny.obj"}]
    scene["lights"].append({"kind": "image", "file": "sky.exr"})
    found = ("cloud.vdb", "albedo.npy", "heat.vdb", "closed.ply", "bunny.obj", "sky.exr")
    assert set(files(parse(json.dumps(scene)))) == set(found)
    assert set(files(with_files(parse(json.dumps(scene)), str.upper))) == set(map(str.upper, found))


def test_files_are_found_beside_the_scene(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(GOOD))
    scene = load(path)
    assert files(scene) == (str(tmp_path / "cloud.vdb"),)
    assert files(with_files(scene, lambda file: "sha256:00")) == ("sha256:00",)
    path.write_text(changed("volumes.0.file", "sha256:00"))
    assert files(load(path)) == ("sha256:00",)


def test_a_missing_scene_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"none.json: No such file or directory$"):
        load(tmp_path / "none.json")
