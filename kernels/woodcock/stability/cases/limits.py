"""Denormal numbers, and what float32 cannot express: that must be refused, with a sentence that says so."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from woodcock.stability import exact
from woodcock.stability.case import Case, Description, by_hits, exactly, inexpressible, on_average
from woodcock.stability.scenes import LOOPS, PATHS, Kind, beam, cube, grid, noise, seen, sky, square

GROUP = "denormals and limits"
VALUES = noise(3, 5, 4)


def _cube(sigma: float, keys: Kind, folder: Path) -> Description:
    return seen(cube(sigma, 0)) | keys


def _sized(size: float, keys: Kind, folder: Path) -> Description:
    return seen(cube(1 / size, 0, size), size=size) | keys


def _grid(largest: float, scale: float, keys: Kind, folder: Path) -> Description:
    return seen(grid(folder, np.full((2, 3, 4), largest, np.float32), 0.0, scale=scale)) | keys


def _glowing(epsilon: float, size: float, keys: Kind, folder: Path) -> Description:
    glow = {"kind": "constant", "epsilon": epsilon}
    return seen(cube(0, 0, size, emission=glow), size=size, lights=[]) | keys


def _lit(radiance: float, keys: Kind, folder: Path) -> Description:
    return seen(cube(1.0, 0), lights=[sky(radiance)]) | keys


def _afar(keys: Kind, folder: Path) -> Description:
    camera = {"kind": "perspective", "origin": [0, 0, -1e30], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 1e-20}
    return seen(cube(1.0, 0), camera=camera) | keys


def _faint(keys: Kind, folder: Path) -> Description:
    """Radiance of 1e-24 of the light, whose square is no number of float32 at all."""
    return seen(cube(1.0, 1e-24), lights=[beam(4e24 * math.pi)]) | keys | square(16)


def _cases() -> Iterator[Case]:
    for sigma in (5e-324, 1e-300, 1e-45, 1e-40, 1e-38):
        yield exactly(GROUP, f"σ = {sigma:g}", partial(_cube, sigma, {}), lambda: 1.0)
        for loop, keys in LOOPS.items():
            yield by_hits(
                GROUP, f"σ = {sigma:g}, {loop}", partial(_cube, sigma, keys), partial(math.exp, -sigma), (0, 64)
            )
    # The smallest float32, denormal ones, and the largest.
    for largest in (2.0**-149, 1e-40, 2.0**-126, 1e30, 3e38):
        scale = 1 / float(np.float32(largest))
        name = f"a grid of {largest:.3g} × {scale:.3g}"
        yield exactly(GROUP, name, partial(_grid, largest, scale, {}), lambda: math.exp(-1))
        for loop, keys in LOOPS.items():
            yield by_hits(
                GROUP, f"{name}, {loop}", partial(_grid, largest, scale, keys), lambda: math.exp(-1), (0, 256)
            )
    for loop, keys in LOOPS.items():
        yield on_average(
            GROUP,
            f"radiance 1e-24 of the light, {loop}",
            partial(_faint, keys),
            lambda: exact.slab(2) / 2,
            (0, 256),
            unresolved="squares of radiance so faint beside the light",
        )
    for size in (1e-30, 1e30):
        yield exactly(GROUP, f"size {size:g}", partial(_sized, size, {}), lambda: math.exp(-1))
        for loop, keys in LOOPS.items():
            yield by_hits(GROUP, f"size {size:g}, {loop}", partial(_sized, size, keys), lambda: math.exp(-1), (0, 64))
    for loop, keys in LOOPS.items():
        yield inexpressible(GROUP, f"σ = 1e300, {loop}", partial(_cube, 1e300, keys))
        yield inexpressible(GROUP, f"σ = 1e40, {loop}", partial(_cube, 1e40, keys))
        yield inexpressible(GROUP, f"a grid of σ = 1e40, {loop}", partial(_grid, 1.0, 1e40, keys))
        yield inexpressible(GROUP, f"size 1e-300, {loop}", partial(_sized, 1e-300, keys))
        yield inexpressible(GROUP, f"size 1e300, {loop}", partial(_sized, 1e300, keys))
    for keys, name in (({}, ""), (PATHS, ", paths")):
        yield inexpressible(GROUP, f"a camera 1e30 sizes away{name}", partial(_afar, keys))
        yield inexpressible(GROUP, f"ε = 1e39{name}", partial(_glowing, 1e39, 1.0, keys))
        yield inexpressible(GROUP, f"ε = 1e-45{name}", partial(_glowing, 1e-45, 1.0, keys))
        yield inexpressible(GROUP, f"ε = 1e30 over 1e12{name}", partial(_glowing, 1e30, 1e12, keys))
        yield inexpressible(GROUP, f"a sky of 1e39{name}", partial(_lit, 1e39, keys))
        yield inexpressible(GROUP, f"a sky of 1e-45{name}", partial(_lit, 1e-45, keys))
        yield inexpressible(GROUP, f"a sky of 1e-300{name}", partial(_lit, 1e-300, keys))


CASES = tuple(_cases())
