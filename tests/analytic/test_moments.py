"""Moments: where paths end that set out along +z in an infinite medium with σ_t = 1. In the mean they collide
1 / (1 - ω) times, are absorbed at z = 1 / (1 - ωg), and at r² = 2 / ((1 - ω) (1 - ωg)): moments of the transport
equation (Case & Zweifel, "Linear transport theory", 1967).

A camera in the medium that sees along +z sends such paths; ε = σ_a f(x) makes its picture the mean of f where they end.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.analytic.scenes import Kind, Picture, Scene, constant, cuboid, is_clean, random_walk
from tests.statistics import accept_z

Values = NDArray[np.float32]


def along(axis: int, values: Any) -> Values:
    """[z][y][x][3] that varies along one axis, 0 to 2 of (x, y, z)."""
    values = np.asarray(values, np.float32)
    return values.reshape(*(len(values) if a == axis else 1 for a in (2, 1, 0)), 3)


def emitter(folder: Path, values: Values, half: Any, brightness: Any, **keys: Any) -> Kind:
    """A grid medium around the origin, of density 1, that emits brightness × values."""
    density, emission = folder / "one.npy", folder / f"emission{len(list(folder.iterdir()))}.npy"
    np.save(density, np.ones((1, 1, 1), np.uint8))
    np.save(emission, values)
    x, y, z = half
    placed = [[2 * x, 0, 0, -x], [0, 2 * y, 0, -y], [0, 0, 2 * z, -z], [0, 0, 0, 1]]
    glow = {"kind": "grid", "file": str(emission), "scale": brightness}
    return {"kind": "grid", "file": str(density), "to_world": placed, "emission": glow, **keys}


def paths_along_z(volumes: list[Kind], seed: int) -> Scene:
    camera = {"kind": "perspective", "origin": [0, 0, 0], "target": [0, 0, 1], "fov": 1e-3}
    film = {"width": 32, "height": 32}
    return random_walk({"camera": camera, "volumes": volumes, "film": film, "seed": seed})


def check(pixels: NDArray[np.float64], expected: float, within: float, what: str) -> None:
    """Pixels are equal in law and independent; is their mean as expected, and known to `within`?"""
    error = pixels.std(ddof=1) / np.sqrt(pixels.size)
    assert error <= within, f"{what}: known to {error:.2g} only"
    accept_z((pixels.mean() - expected) / error, what)


def extent(albedo: float, g: float) -> float:
    """So far that next to nothing of a path is beyond: thirty diffusion lengths, or free paths."""
    return 30 * max(1.2, 1 / np.sqrt(3 * (1 - albedo) * (1 - albedo * g)))


CASES = [(g, albedo) for albedo in (0.5, 0.99) for g in (-0.5, 0, 0.9, 0.999)]
STIFF = [pytest.param(g, 0.9999, marks=(pytest.mark.slow, pytest.mark.timeout(7200))) for g in (0, 0.9, 0.999)]
#: Paths per pixel, by ω: what a path costs is the number of its collisions.
SAMPLES = {0.5: 1024, 0.99: 24, 0.9999: 8}


@pytest.mark.parametrize(("g", "albedo"), [*CASES, *STIFF[-1:]])
def test_collisions_and_depth(tmp_path: Path, picture: Picture, g: float, albedo: float) -> None:
    """The medium is a grid. Red and green are z above and below the origin, for which trilinear interpolation is exact;
    blue is 1 for each collision."""
    end = extent(albedo, g)
    # Three layers, whose middles are at -end, 0 and end.
    values = along(2, [[0, 1, 1], [0, 0, 1], [1, 0, 1]])
    brightness = [(1 - albedo) * end, (1 - albedo) * end, 1]
    medium = emitter(
        tmp_path, values, (end, end, 1.5 * end), brightness, albedo=albedo, phase={"kind": "henyey_greenstein", "g": g}
    )
    film = picture(paths_along_z([medium], 41), SAMPLES[albedo])
    assert is_clean(film)
    above, below, collisions = film.mean.reshape(-1, 3).T
    check(collisions, 1 / (1 - albedo), 2e-3 / (1 - albedo), "collisions")
    depth = 1 / (1 - albedo * g)
    spread = np.sqrt(2 * depth / (1 - albedo))
    check(above - below, depth, 5e-3 * spread + 2e-3 * depth, "z")


@pytest.mark.parametrize(("g", "albedo"), [*CASES, *STIFF])
def test_distance(tmp_path: Path, picture: Picture, g: float, albedo: float) -> None:
    """A constant medium, and grids without extinction in it that emit x², y² and z². Linear between layers h apart,
    each is too large by h² / 6 in the mean: next to nothing, and accounted for."""
    end, layers = extent(albedo, g), 8192
    middles = (np.arange(layers) + 0.5) * (2 / layers) - 1
    too_much = 3 * (2 * end / layers) ** 2 / 6
    medium = constant(cuboid(-end, end), 1, albedo, phase={"kind": "henyey_greenstein", "g": g})
    squares = [
        emitter(
            tmp_path,
            along(axis, np.eye(3)[[axis] * layers] * middles[:, None] ** 2),
            (end, end, end),
            (1 - albedo) * end**2,
            albedo=0,
            scale=0,
        )
        for axis in range(3)
    ]
    film = picture(paths_along_z([medium, *squares], 42), SAMPLES[albedo])
    assert is_clean(film)
    expected = 2 / ((1 - albedo) * (1 - albedo * g))
    assert too_much < 1e-4 * expected
    check(film.mean.sum(axis=-1).reshape(-1), expected + too_much, 0.015 * expected, "r²")
