"""The scenes of the comparison as pbrt's text: read back, and rendered by a stand-in that answers as pbrt would.

Read back by this project's own reader of pbrt's scenes, which knows colours but no bands: they are made colours first,
as pbrt takes them.
"""

from __future__ import annotations

import importlib
import json
import re
import stat
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813 - its own usual name
import pytest
from tests.benchmarks.peers import scenes

from woodcock.camera import orthographic, perspective
from woodcock.formats.mesh import read_mesh
from woodcock.importing import Report, convert
from woodcock.scene import PerspectiveCamera, Scene, load

PEERS = Path(scenes.__file__).parent
#: Shares of luminance, red first; any will do that are no equal thirds.
SHARES = np.array([0.3, 0.6, 0.1])
CASES = {case.name: case for case in scenes.CASES}


@pytest.fixture
def sides(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[ModuleType, ModuleType]]:
    """The adapter's modules, found beside each other as when it is run."""
    monkeypatch.syspath_prepend(str(PEERS))
    yield importlib.import_module("pbrt_scene"), importlib.import_module("pbrt_side")
    for name in ("pbrt_scene", "pbrt_side", "protocol"):
        sys.modules.pop(name, None)


def job(case: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Writes peer.json of a case, its grids made small; those of others are made up."""
    rng, phantom = np.random.default_rng(1), scenes.phantom
    density = rng.random((4, 6, 5)) * np.pad(np.ones((2, 4, 3)), 1)
    to_scene = np.array([[-2, 0, 0, 1], [0, 0, -3, 2], [0, 1, 0, 3], [0, 0, 0, 1.0]])
    grid = SimpleNamespace(values=density, index_to_world=to_scene @ np.diag((1 / 5, 1 / 6, 1 / 4, 1)))
    monkeypatch.setattr(scenes, "read_grid", lambda path, name: grid)
    monkeypatch.setattr(scenes, "noise", lambda n: density)
    monkeypatch.setattr(scenes, "phantom", lambda n: phantom(9))
    monkeypatch.setattr(scenes, "DATA", folder)
    (folder / "smoke.vdb").write_bytes(b"made up")
    scene = CASES[case].written(folder)
    whole = Scene.model_validate(scene).model_dump(mode="json")
    grids = {}
    for volume in whole["volumes"]:
        for file in [volume.get("file"), (volume["emission"] or {}).get("file")]:
            if file is not None:
                values = density if file == "smoke.vdb" else np.load(folder / file)
                values = values[::8, ::8, ::8] if len(values) > 16 else values
                np.save(folder / f"{file}.float.npy", values.astype(np.float32))
                placed = to_scene if file == "smoke.vdb" else np.array(volume["to_world"])
                grids[file] = {"values": f"{file}.float.npy", "to_scene": placed.tolist()}
    described = {"scene": whole, "grids": grids}
    (folder / "peer.json").write_text(json.dumps(described))
    return described


def in_colours(text: str) -> str:
    """Bands as colours; lights' divided by their luminance, as pbrt does."""

    def colour(found: re.Match[str]) -> str:
        blue, green, red = np.array(found[2].split(), float)[[1, 5, 9]]
        rgb = np.array([red, green, blue])
        rgb = rgb / (SHARES @ rgb) if found[1] in "LI" else rgb
        return f'"rgb {found[1]}" [{rgb[0]} {rgb[1]} {rgb[2]}]'

    return re.sub(r'"spectrum (\w+)" \[([^]]*)\]', colour, text)


@pytest.mark.parametrize("case", CASES)
def test_what_is_written_is_the_scene(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sides: tuple[ModuleType, ModuleType]
) -> None:
    described, (writing, side) = job(case, tmp_path, monkeypatch), sides
    colours = writing.Spectra() if case == "fire" else writing.Bands(SHARES)
    text = in_colours(writing.written(side.Job.read(tmp_path), colours))
    (tmp_path / "scene.pbrt").write_text(text)
    report = Report()
    convert(tmp_path / "scene.pbrt", tmp_path / "out.json", report)
    said = {
        "paths have any length here; pbrt's end after 1000000 scatterings: it is darker",
        "not checked that the shape holds all of the grid of its medium, which is not cut",
        "towards the faces of the box the grid keeps its last value here, where pbrt's fades to half of it",
        '"Le" and what absorbs are multiplied at the voxels, and interpolated together',
    }
    assert {note.what for note in report.notes} <= said
    scene, back = Scene.model_validate(described["scene"]), load(tmp_path / "out.json")
    assert (back.film.width, back.film.height, back.film.filter) == (scene.film.width, 256, scene.film.filter)
    u, v = np.random.default_rng(2).random((2, 20))
    kind = perspective if isinstance(scene.camera, PerspectiveCamera) else orthographic
    for found, wanted in zip(kind.ray(back.camera, 1, u, v), kind.ray(scene.camera, 1, u, v), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-5, atol=1e-5)
    same(lights(back), lights(scene))
    same(surfaces(back), surfaces(scene))
    medium, wanted = back.volumes[0].model_dump(), scene.volumes[0].model_dump()
    assert len(back.volumes) == 1
    same(optics(medium), optics(wanted))
    assert [insides > 0 for insides in meshes(text)] == [True] * (case != "milk")
    if wanted["kind"] == "grid":
        same_grid(described["grids"], wanted, medium, tmp_path)
        if case == "fire":
            epsilon = np.load(tmp_path / "emission.npy")
            absorbed = wanted["scale"] * (1 - wanted["albedo"]) * np.load(tmp_path / "density.npy")
            glow = absorbed[..., None] * writing.emitted(epsilon, absorbed)
            back = medium["emission"]["scale"] * np.load(tmp_path / medium["emission"]["file"])[1:-1, 1:-1, 1:-1]
            np.testing.assert_allclose(back, glow, rtol=1e-5)
    elif wanted["shape"]["kind"] == "box":
        mesh = read_mesh(tmp_path / medium["shape"]["file"])
        same([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)], [wanted["shape"]["min"], wanted["shape"]["max"]])
    else:
        same(medium["shape"], wanted["shape"])


def meshes(text: str) -> list[float]:
    """Volumes of the text's meshes: less than 0 if their triangles, counter-clockwise, face inwards."""
    found = []
    for corners, faces in re.findall(r'"trianglemesh" "point3 P" \[([^]]*)\] "integer indices" \[([^]]*)\]', text):
        triangles = np.array(corners.split(), float).reshape(-1, 3)[np.array(faces.split(), int).reshape(-1, 3)]
        found.append(float(np.sum(np.linalg.det(triangles))) / 6)
    return found


def same_grid(grids: dict[str, Any], wanted: dict[str, Any], found: dict[str, Any], folder: Path) -> None:
    """Voxels within a layer of copies, where they were."""
    values, density = np.load(folder / found["file"]), np.load(folder / grids[wanted["file"]]["values"])
    values = values if values.ndim == 3 else values[..., 0]
    np.testing.assert_allclose(found["scale"] * values, wanted["scale"] * np.pad(density, 1, mode="edge"), rtol=1e-5)
    counts = np.array(density.shape[::-1])
    padded = np.diag((*(1 + 2 / counts), 1.0))
    padded[:3, 3] = -1 / counts
    placed = np.array(grids[wanted["file"]]["to_scene"]) @ padded
    np.testing.assert_allclose(found["to_world"], placed, rtol=1e-5, atol=1e-6)
    assert (found["emission"] is None) == (wanted["emission"] is None)


def lights(scene: Scene) -> list[dict[str, Any]]:
    """With directions of unit length."""
    listed = [light.model_dump() for light in scene.lights]
    for light in listed:
        if "direction" in light:
            light["direction"] = np.array(light["direction"]) / np.linalg.norm(light["direction"])
    return listed


def optics(volume: dict[str, Any]) -> list[Any]:
    g = volume["phase"].get("g", 0)
    return [volume.get("sigma_t", 0), volume["albedo"], g]


def surfaces(scene: Scene) -> list[dict[str, Any]]:
    """Rectangles without the length of their normal, which means nothing."""
    listed = [surface.model_dump() for surface in scene.surfaces]
    for surface in listed:
        if "to_world" in surface:
            normal = np.array(surface["to_world"])[:3, 2]
            surface["to_world"] = [row[:2] + row[3:] for row in surface["to_world"]]
            surface["normal"] = normal / np.linalg.norm(normal)
    return listed


def same(found: Any, wanted: Any) -> None:
    """Equal but for rounding; one number stands for three that are the same."""
    if isinstance(wanted, dict):
        assert found.keys() == wanted.keys()
        for key in wanted:
            same(found[key], wanted[key])
    elif isinstance(wanted, str | None):
        assert found == wanted
    elif isinstance(wanted, list | tuple) and not all(isinstance(item, int | float) for item in wanted):
        assert len(found) == len(wanted)
        for one, other in zip(found, wanted, strict=True):
            same(one, other)
    else:
        size = max(np.shape(found), np.shape(wanted))
        np.testing.assert_allclose(np.broadcast_to(found, size), np.broadcast_to(wanted, size), rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"camera": {"kind": "spherical", "origin": [0, 0, 0], "target": [0, 0, 1]}}, "the camera spherical"),
        ({"lights": [{"kind": "sun", "direction": [0, 1, 0], "irradiance": 1}]}, "the light sun"),
        ({"film": {"filter": {"kind": "tent"}}}, "pixel filters"),
    ],
)
def test_what_cannot_be_written_says_so(
    change: dict[str, Any],
    reason: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    sides: tuple[ModuleType, ModuleType],
) -> None:
    writing, side = sides
    described = job("cloud", tmp_path, monkeypatch)
    whole = Scene.model_validate({**CASES["cloud"].write(tmp_path), **change}).model_dump(mode="json")
    (tmp_path / "peer.json").write_text(json.dumps({**described, "scene": whole}))
    with pytest.raises(writing.Skip, match=reason):
        writing.written(side.Job.read(tmp_path), writing.Spectra())


def test_a_product_of_two_grids_emits_what_one_does(sides: tuple[ModuleType, ModuleType]) -> None:
    """By sums over 8³ points of every cell: in all, and in rays along each axis; ε / σ_a alone would be far off."""
    rng = np.random.default_rng(3)
    sigma = np.pad(rng.random((6, 7, 8)), 2)
    epsilon = sigma[..., None] * (1 + np.pad(rng.random((6, 7, 8, 3)), ((2, 2), (2, 2), (2, 2), (0, 0))))

    def fine(values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        for axis in range(3):
            places = np.arange(8 * (values.shape[axis] - 1)) / 8 + 1 / 16
            low = places.astype(int)
            share = (places - low).reshape([-1 if a == axis else 1 for a in range(values.ndim)])
            values = values.take(low, axis) * (1 - share) + values.take(low + 1, axis) * share
        return values

    wanted = fine(epsilon)
    found = fine(sigma)[..., None] * fine(sides[0].emitted(epsilon, sigma))
    naive = fine(sigma)[..., None] * fine(epsilon / np.where(sigma > 0, sigma, 1)[..., None])
    totals = (array.sum(axis=(0, 1, 2)) / wanted.sum(axis=(0, 1, 2)) for array in (found, naive))
    close, far = (abs(total - 1).max() for total in totals)
    assert (close < 0.0004, far > 0.1) == (True, True)
    for axis in range(3):
        rays = wanted.sum(axis=axis)
        assert np.sqrt(np.mean((found.sum(axis=axis) - rays) ** 2)) < 0.004 * rays.max()


@pytest.mark.parametrize("compression", ["zip", "zips", "none"])
def test_pictures_are_read(compression: str, tmp_path: Path, sides: tuple[ModuleType, ModuleType]) -> None:
    """Smooth lines pack, those of noise do not and are kept as they are."""
    image = np.random.default_rng(4).standard_normal((37, 5, 3)).astype(np.float32)
    image[:20] = np.linspace(-1, 1, 20 * 5 * 3, dtype=np.float32).round(1).reshape(20, 5, 3)
    spec = oiio.ImageSpec(5, 37, 3, oiio.FLOAT)
    spec.attribute("compression", compression)
    spec.attribute("renderTimeSeconds", 1.25)
    path = tmp_path / "picture.exr"
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(image)
    assert output.close()
    found, seconds = sides[1].read_exr(path)
    np.testing.assert_array_equal(found, image)
    assert seconds == 1.25


def test_the_whole_protocol(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The film's colours come back as the light's own, though the stand-in shows them otherwise."""
    described = job("cloud_sun", tmp_path, monkeypatch)
    described["scene"]["film"] |= {"width": 5, "height": 3}
    (tmp_path / "peer.json").write_text(json.dumps(described))
    program = tmp_path / "pbrt"
    program.write_text(f"#!{sys.executable}\n" + (PEERS.parent / "pbrt_stand_in.py").read_text())
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    asked = "".join(json.dumps({"samples": 16, "seed": seed}) + "\n" for seed in (1, 13, 2))
    monkeypatch.setenv("WOODCOCK_PBRT", str(program))
    command = [sys.executable, str(PEERS / "pbrt_side.py"), str(tmp_path)]
    done = subprocess.run(command, input=asked, capture_output=True, text=True, check=True, timeout=60)
    described, one, failed, two = map(json.loads, done.stdout.splitlines())
    assert (described["name"], described["version"]) == ("pbrt-v4 volpath", "4 (built Jan  1 2026 at 12:00:00)")
    assert "fixed wavelengths" in described["settings"]
    assert failed == {"error": "RuntimeError: pbrt: Error: out of luck"}
    for seed, answer in ((1, one), (2, two)):
        assert answer == {"seconds": 0.25, "image": f"pbrt_side-{seed}.npy"}
        expected = np.multiply.outer(1 + np.arange(3) * seed, np.array([0.3, 0.5, 0.9]))
        expected = np.repeat(expected[:, None], 5, axis=1)
        np.testing.assert_allclose(np.load(tmp_path / answer["image"]), expected, rtol=1e-5)


def test_without_pbrt_it_is_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sides: tuple[ModuleType, ModuleType]
) -> None:
    job("milk", tmp_path, monkeypatch)
    monkeypatch.delenv("WOODCOCK_PBRT", raising=False)
    with pytest.raises(sides[0].Skip, match="WOODCOCK_PBRT"):
        sides[1].make(sides[1].Job.read(tmp_path))
