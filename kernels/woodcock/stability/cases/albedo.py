"""Albedo 0, 1e-6 to 1 - 1e-6, and 1: what a half-space reflects, and an isothermal furnace."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from woodcock.stability import exact
from woodcock.stability.case import Case, Description, on_average
from woodcock.stability.scenes import LOOPS, PATHS, Kind, block, cube, parallel, seen, square

GROUP = "albedo"
ALBEDOS = {
    "0": 0.0,
    **{f"1e-{n}": 10.0**-n for n in range(6, 0, -1)},
    "0.5": 0.5,
    "0.9": 0.9,
    **{f"1 - 1e-{n}": 1 - 10.0**-n for n in range(2, 7)},
    "1": 1.0,
}


def _half_space(albedo: float, below: bool, keys: Kind, folder: Path) -> Description:
    """σ_t = 1, seen from under z = 0, or from above; so deep that hardly any light gets through."""
    depth = max(40.0, 12 / math.sqrt(3 * (1 - albedo)))
    low, high = (0.0, depth) if below else (-depth, 0.0)
    medium = block(1.0, albedo, (-10 * depth, -10 * depth, low), (10 * depth, 10 * depth, high))
    camera = parallel((0, 0, -1 if below else 1), (0, 0, 0), 1)
    return seen(medium, camera=camera) | keys


def _slab(albedo: float, keys: Kind, folder: Path) -> Description:
    medium = block(1.0, albedo, (-1e4, -1e4, 0), (1e4, 1e4, THICK))
    return seen(medium, camera=parallel((0, 0, -1), (0, 0, 0), 1)) | keys | square(16)


def _isothermal(albedo: float, folder: Path) -> Description:
    """Source function and sky of 1."""
    glow = {"kind": "constant", "epsilon": (1 - albedo) * THICK}
    return seen(cube(THICK, albedo, emission=glow)) | PATHS | square(16)


#: Optical depth of the slab and of the cube.
THICK = 20.0


def _cases() -> Iterator[Case]:
    for name, albedo in ALBEDOS.items():
        for loop, keys in LOOPS.items():
            # From 1 - 1e-4 on paths are too long, and those few that absorb something too rare.
            if 0 < albedo < 0.9999:
                samples = (0, 1024) if albedo < 0.9 else (0, 256)
                scene = partial(_half_space, albedo, loop == "paths", keys)
                right = partial(exact.half_space, albedo)
                yield on_average(GROUP, f"ω = {name}, half-space, {loop}", scene, right, samples)
            if albedo > 0:
                slab, right = partial(_slab, albedo, keys), partial(exact.lit_slab, albedo, 0.0, THICK)
                yield on_average(GROUP, f"ω = {name}, slab, {loop}", slab, right, (0, 64))
        isothermal = partial(_isothermal, albedo)
        yield on_average(GROUP, f"ω = {name}, isothermal furnace", isothermal, lambda: 1.0, (0, 64))


CASES = tuple(_cases())
