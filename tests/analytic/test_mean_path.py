"""Mean path: under isotropic light from everywhere, paths through a convex body that absorbs nothing are 4V/S long in
the mean, whatever scatters in it (Blanco & Fournier, EPL 61, 2003).

A medium with ε = 1 makes a picture of lengths: their sum over a view's area, in the mean of all views, is
S/4 · 4V/S = V.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.analytic.scenes import PHASES, Grid, Kind, Picture, Scene, agree, ball, constant, cuboid, is_clean, noise
from tests.statistics import accept_mean

GLOW: Kind = {"emission": {"kind": "constant", "epsilon": 1}}
SIGMAS = [0.1, 3, 30, [0.3, 3, 10]]


def seen(scene: Scene, direction: Any, height: float) -> Scene:
    origin = 0.5 - 2 * np.asarray(direction)
    up = np.roll(direction, 1) + np.array([0.1, 0.0, 0.0])
    camera = {
        "kind": "orthographic",
        "origin": origin.tolist(),
        "target": [0.5] * 3,
        "up": up.tolist(),
        "height": height,
    }
    return scene | {"camera": camera, "lights": []}


@pytest.mark.parametrize(
    "phase", ["henyey_greenstein", *(pytest.param(p, marks=pytest.mark.slow) for p in ("isotropic", "rayleigh"))]
)
@pytest.mark.parametrize("sigma", [3, *(pytest.param(s, marks=pytest.mark.slow) for s in SIGMAS if s != 3)], ids=str)
def test_of_a_sphere(box: Scene, picture: Picture, sigma: Any, phase: str) -> None:
    """4R/3; every view of it is like every other."""
    radius = 0.7
    box["volumes"] = [constant(ball(radius=radius), sigma, 1, phase=PHASES[phase], **GLOW)]
    height = 1.5
    film = picture(seen(box, [0.6, 0, 0.8], height), 1024)
    agree((height**2 / (np.pi * radius**2), film), expected=4 * radius / 3, within=0.004)


def views(count: int) -> np.ndarray:
    """(count², 3): directions, one in each of as many parts of the sphere of the same size, at random."""
    rng = np.random.default_rng(12)
    u, v = ((np.indices((count, count)) + rng.random((2, count, count))) / count).reshape(2, -1)
    sine = 2 * np.sqrt(v * (1 - v))
    return np.stack([sine * np.cos(2 * np.pi * u), sine * np.sin(2 * np.pi * u), 2 * v - 1], axis=-1)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["constant", "grid", "both"])
@pytest.mark.parametrize("sigma", SIGMAS, ids=str)
def test_of_a_cube(box: Scene, grid: Grid, picture: Picture, kind: str, sigma: Any) -> None:
    """2/3 of its side, however its scattering is spread in it."""
    phase = PHASES["henyey_greenstein"]
    volumes = {
        "constant": [constant(cuboid(), sigma, 1, phase=phase, **GLOW)],
        "grid": [grid(noise(3, 4, 2) ** 3, scale=sigma, albedo=1, phase=phase, **GLOW)],
        "both": [constant(cuboid(), sigma, 1), grid(noise(5, 5, 5), scale=sigma, albedo=1, phase=phase, **GLOW)],
    }
    box |= {"volumes": volumes[kind], "film": {"width": 16, "height": 16}}
    height = 1.8
    # Each with a seed of its own, for their errors must not be the same.
    films = [picture(seen(box, view, height) | {"seed": seed}, 128) for seed, view in enumerate(views(8))]
    assert all(map(is_clean, films))
    volume = height**2 * np.array([film.mean.mean() for film in films])
    assert volume.std() / np.sqrt(len(films)) < 0.02
    # Directions spread evenly err less than directions at random would.
    accept_mean(volume, 1, exact=False)
