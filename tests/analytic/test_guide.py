"""Directions that are guided towards lights leave every mean as it is: pictures with and without them agree."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.analytic.scenes import PHASES, Grid, Kind, Picture, Scene, constant, cuboid, noise, random_walk, same

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
