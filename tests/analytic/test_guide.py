"""Directions that are guided towards lights leave every mean as it is: pictures with and without them agree."""

from __future__ import annotations

from pathlib import Path
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
    white_image,
)

from woodcock.integrator import guide

POINT: Kind = {"kind": "point", "position": [1.2, 0.3, 0.2], "intensity": [3, 2, 1]}
SPOT: Kind = {"kind": "spot", "position": [0.4, -0.3, 0.1], "target": [0.5, 0.6, 0.5], "intensity": 3, "cutoff": 40}
BEAM: Kind = {"kind": "directional", "direction": [1, 0.3, 0.6], "irradiance": [4, 3, 2]}
SUN: Kind = {"kind": "sun", "direction": [-1, 0.5, 0.2], "irradiance": 4, "angular_radius": 12}
BACK: Kind = {"kind": "henyey_greenstein", "g": -0.6}


@pytest.mark.parametrize(
    ("lights", "phase", "gridded"),
    [
        ([BEAM], PHASES["henyey_greenstein"], True),
        ([BEAM, POINT, SPOT, SUN], PHASES["mixture"], False),
        pytest.param([SUN], PHASES["mie_approx"], True, marks=pytest.mark.slow),
        pytest.param([SPOT, SUN], BACK, False, marks=pytest.mark.slow),
    ],
    ids=["beam", "several", "sun", "backward"],
)
def test_guided_and_not(
    box: Scene,
    grid: Grid,
    picture: Picture,
    monkeypatch: pytest.MonkeyPatch,
    lights: list[Kind],
    phase: Kind,
    gridded: bool,
) -> None:
    """The environment is found by chance, too, and must be weighed by the same densities. Shares are made large."""
    monkeypatch.setattr(guide, "OPAQUE", 1.0)
    volume = (
        grid(noise(5, 4, 6), scale=6, albedo=0.9, phase=phase) if gridded else constant(cuboid(), 3, 0.9, phase=phase)
    )
    scene: dict[str, Any] = random_walk(box, volumes=[volume], lights=[*box["lights"], *lights])
    guided, few = picture(scene, 2048), picture(scene, 4)
    monkeypatch.setattr(guide, "guides", lambda *_: False)
    same(picture(scene | {"seed": 8}, 2048), guided, within=0.01)
    assert not np.array_equal(picture(scene, 4).mean, few.mean)  # or nothing was guided


def test_guided_from_surfaces(box: Scene, picture: Picture, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Rough ones, that is; the environment is found by chance as well, and a lamp."""
    monkeypatch.setattr(guide, "OPAQUE", 1.0)
    glass = {"kind": "rough_dielectric", "ior": 1.5, "roughness": 0.4}
    surfaces = [
        rectangle([0.8, 0, 0], [0, 0.6, 0.5], [0.5, 0.5, 0.6], {"kind": "diffuse", "reflectance": [0.9, 0.7, 0.5]}),
        {**ball((0.3, 0.4, 0.2), 0.15), "material": glass},
        {**ball((0.8, 0.6, 0.2), 0.15), "material": {"kind": "mirror", "reflectance": 1}},
        {**ball((0.2, 0.9, 0.1), 0.1), "material": {"kind": "emissive", "radiance": 3}},
    ]
    fog = constant(cuboid(), 1.5, 0.9, phase=PHASES["henyey_greenstein"])
    scene: dict[str, Any] = random_walk(
        box, volumes=[fog], surfaces=surfaces, lights=[white_image(tmp_path), SPOT, SUN]
    )
    guided = picture(scene, 1024)
    monkeypatch.setattr(guide, "guides", lambda *_: False)
    same(picture(scene | {"seed": 8}, 1024), guided, within=0.01)
