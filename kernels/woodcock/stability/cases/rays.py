"""Rays that graze, run parallel to axes, along faces, through edges and corners."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from woodcock.stability import exact
from woodcock.stability.case import Case, Description, by_hits, exactly
from woodcock.stability.scenes import LOOPS, Kind, Point, ball, cube, grid, noise, parallel, seen

GROUP = "rays"
VALUES = noise(4, 4, 4)
EXACT = 2.0 * VALUES.astype(float)

#: By where they pass, and by their direction; in the unit cube, of 4 × 4 × 4 voxels.
PLACES: dict[str, tuple[Point, Point]] = {
    "along x through voxels' middles": ((0.0, 0.375, 0.625), (1, 0, 0)),
    "along y through voxels' middles": ((0.375, 0.0, 0.625), (0, 1, 0)),
    "along -z through voxels' middles": ((0.375, 0.625, 1.0), (0, 0, -1)),
    "along x on a face between voxels": ((0.0, 0.5, 0.6), (1, 0, 0)),
    "along -y on an edge between voxels": ((0.5, 1.0, 0.25), (0, -1, 0)),
    "through corners of voxels": ((0.0, 0.0, 0.0), (1, 1, 1)),
    "through corners of voxels, back": ((1.0, 0.0, 1.0), (-1, 1, -1)),
    "through edges of voxels": ((0.0, 0.0, 0.4), (1, 1, 0)),
    "1e-3 from parallel": ((0.0, 0.4, 0.5), (1, 1e-3, -1e-3)),
    "1e-6 from parallel": ((0.0, 0.4, 0.5), (1, 1e-6, -1e-6)),
    "1e-12 from parallel": ((0.0, 0.4, 0.5), (1, 1e-12, -1e-12)),
    "1e-30 from parallel": ((0.0, 0.4, 0.5), (1, 1e-30, -1e-30)),
    "grazing a face by 1e-3": ((0.0, 1e-3, 0.3), (1, -1e-3 + 1e-9, 0)),
    "grazing a face by 1e-6": ((0.0, 1e-6, 0.3), (1, -1e-7, 0)),
    "cutting off an edge by 1e-3": ((0.0, 1 - 1e-3, 0.3), (1, 1, 0)),
    "cutting off a corner by 1e-3": ((1 - 1e-3, 0.0, 1 - 1e-3), (1, 2, 1)),
}


def _view(place: Point, direction: Point) -> Kind:
    """One ray, for the picture is too small to see another."""
    p, d = np.array(place), np.array(direction, float)
    up = (0.0, 0.0, 1.0) if abs(d[2]) < 0.9 * np.linalg.norm(d) else (1.0, 0.0, 0.0)
    origin, target = p - 2 * d, p + d
    return parallel((*origin.tolist(),), (*target.tolist(),), 1e-12, up)


def _grid(view: Kind, keys: Kind, folder: Path) -> Description:
    return seen(grid(folder, VALUES, 0.0, scale=2.0), camera=view) | keys


def _cube(view: Kind, keys: Kind, folder: Path) -> Description:
    return seen(cube(2.0, 0), camera=view) | keys


def _ball(view: Kind, keys: Kind, folder: Path) -> Description:
    return seen(ball(2.0, 0, 1.0, (0, 0, 0)), camera=view) | keys


def _through(values: exact.Array, place: Point, direction: Point) -> float:
    return math.exp(-exact.depth_of_ray(values, np.array(place), np.array(direction)))


def _chord(gap: float) -> float:
    """Through a ball of radius 1, of σ_t = 2, 1 - gap from its middle."""
    return math.exp(-4 * math.sqrt(gap * (2 - gap)))


def _cases() -> Iterator[Case]:
    constant = np.full((1, 1, 1), 2.0)
    for name, (place, direction) in PLACES.items():
        view = _view(place, direction)
        right, plain = partial(_through, EXACT, place, direction), partial(_through, constant, place, direction)
        yield exactly(GROUP, f"{name}, grid", partial(_grid, view, {}), right)
        yield exactly(GROUP, f"{name}, cube", partial(_cube, view, {}), plain)
        for loop, keys in LOOPS.items():
            yield by_hits(GROUP, f"{name}, grid, {loop}", partial(_grid, view, keys), right, (0, 256))
    for gap in (1e-2, 1e-4, 1e-6):
        view = _view((1 - gap, 0, 0), (0, 0, 1))
        name = f"{gap:g} of its radius inside a ball's limb"
        yield exactly(GROUP, name, partial(_ball, view, {}), partial(_chord, gap))
        yield exactly(GROUP, f"{gap:g} outside", partial(_ball, _view((1 + gap, 0, 0), (0, 0, 1)), {}), lambda: 1.0)
    for gap in (1e-2, 1e-4):
        for loop, keys in LOOPS.items():
            paths = partial(_ball, _view((1 - gap, 0, 0), (0, 0, 1)), keys)
            yield by_hits(GROUP, f"{gap:g} inside a ball's limb, {loop}", paths, partial(_chord, gap), (0, 256))


CASES = tuple(_cases())
