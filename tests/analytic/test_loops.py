"""Scenes that more than one loop or estimator solves: all of them agree."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.analytic.scenes import (
    PHASES,
    Grid,
    Kind,
    Picture,
    Scene,
    ball,
    constant,
    cuboid,
    noise,
    random_walk,
    rectangle,
    same,
)

from woodcock.integrator import volumetric_path

BEAM: Kind = {"kind": "directional", "direction": [1, 0.3, 0.6], "irradiance": [4, 3, 2]}
CAMERAS: dict[str, Kind] = {
    "perspective": {
        "kind": "perspective",
        "origin": [0.2, 0.1, -1],
        "target": [0.5, 0.5, 0.5],
        "up": [0, -1, 0],
        "fov": 60,
    },
    "spherical": {"kind": "spherical", "origin": [0.4, 0.5, 0.6], "target": [0.5, 0.5, 1.5], "up": [0, -1, 0]},
}


@pytest.mark.parametrize(
    "camera", ["orthographic", *(pytest.param(camera, marks=pytest.mark.slow) for camera in CAMERAS)]
)
@pytest.mark.parametrize("medium", ["constant", "grid", "cells"])
@pytest.mark.parametrize("phase", ["henyey_greenstein", pytest.param("isotropic", marks=pytest.mark.slow)])
def test_simple_and_full(
    box: Scene, grid: Grid, picture: Picture, monkeypatch: pytest.MonkeyPatch, medium: str, phase: str, camera: str
) -> None:
    keys = {"albedo": [0.95, 0.8, 0.6], "phase": PHASES[phase]}
    volume = constant(cuboid(), 3, **keys) if medium == "constant" else grid(noise(5, 4, 6), scale=6, **keys)
    scene = random_walk(box, volumes=[volume], lights=[*box["lights"], BEAM])
    scene["majorant"] = {"kind": "grid", "resolution": 3} if medium == "cells" else {"kind": "global"}
    scene["camera"] = CAMERAS.get(camera, box["camera"])
    simple, few = picture(scene, 512), picture(scene, 4)
    monkeypatch.setattr(volumetric_path, "suits", lambda *_: False)
    same(picture(scene | {"seed": 8}, 512), simple)
    assert not np.array_equal(picture(scene, 4).mean, few.mean)  # or it was the same loop


# Equiangular sampling, which a grid anywhere in the scene turns off

POINT: Kind = {"kind": "point", "position": [1.2, 0.3, 0.2], "intensity": [3, 2, 1]}
SPOT: Kind = {"kind": "spot", "position": [0.4, -0.3, 0.1], "target": [0.5, 0.6, 0.5], "intensity": 3, "cutoff": 40}


@pytest.fixture
def nothing(grid: Grid) -> Kind:
    """A grid beside the scene that is hardly there."""
    place = [[0.01, 0, 0, 1.1], [0, 0.01, 0, 1.1], [0, 0, 0.01, 1.1], [0, 0, 0, 1]]
    return grid(np.ones((1, 1, 1), np.float32), scale=1e-6, albedo=0, to_world=place)


SCENES: dict[str, tuple[list[Kind], list[Kind], list[Kind]]] = {
    "box": ([constant(cuboid(), 3, 0.9)], [], [POINT]),
    "coloured": ([constant(cuboid(), [0.5, 2, 6], 0.9, phase=PHASES["draine"])], [], [POINT, SPOT]),
    "sphere": ([constant(ball(), 4, [0.9, 0.8, 0.7], phase=PHASES["henyey_greenstein"])], [], [SPOT]),
    "several": (
        [
            constant(ball(), 4, 0.9),
            constant(cuboid(0.3, 1.1), [3, 1, 0], [0.9, 0.5, 0.8], phase=PHASES["henyey_greenstein"]),
            constant(cuboid(-0.2, 0.4), 1, 1, phase=PHASES["two_lobe"]),
        ],
        [],
        [POINT, SPOT, BEAM, {"kind": "constant", "radiance": 0.2}],
    ),
    "shadow": (
        [constant(cuboid(), 2, 0.9, phase=PHASES["rayleigh"])],
        [
            rectangle([0, 0.2, 0], [0, 0, 0.2], [1.05, 0.4, 0.3], {"kind": "diffuse", "reflectance": 0.7}),
            rectangle([0.3, 0, 0], [0, 0.3, 0.3], [0.4, 0.6, 0.5], {"kind": "diffuse", "reflectance": 0.7}),
            {**ball((0.5, 0.5, 0.5), 0.4), "material": {"kind": "null"}},
            {**ball((0.2, 0.8, 0.5), 0.1), "material": {"kind": "emissive", "radiance": 0.5}},
        ],
        [POINT, SPOT],
    ),
}


@pytest.mark.parametrize(
    "name",
    [
        *(pytest.param(n, marks=pytest.mark.slow) for n in SCENES if n != "coloured"),
        "coloured",
    ],
)
def test_with_and_without_equiangular_sampling(box: Scene, picture: Picture, nothing: Kind, name: str) -> None:
    volumes, surfaces, lights = SCENES[name]
    scene: dict[str, Any] = random_walk(box, volumes=volumes, surfaces=surfaces, lights=lights)
    same(picture(scene, 4096), picture(scene | {"volumes": [*volumes, nothing], "seed": 8}, 4096), within=0.006)


@pytest.mark.parametrize("sigma", [3, pytest.param([0.5, 2, 6], marks=pytest.mark.slow)], ids=str)
def test_point_light_on_a_constant_grid(box: Scene, grid: Grid, picture: Picture, sigma: Any) -> None:
    phase = PHASES["henyey_greenstein"]
    scene = random_walk(box, volumes=[constant(cuboid(), sigma, 0.9, phase=phase)], lights=[POINT, SPOT])
    ones = grid(np.ones((2, 3, 2), np.float32), scale=sigma, albedo=0.9, phase=phase)
    same(picture(scene, 4096), picture(scene | {"volumes": [ones], "seed": 8}, 4096), within=0.01)
