"""What the scenes of cases are made of."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from woodcock.stability.case import Description

Kind = dict[str, Any]
Point = tuple[float, float, float]
Values = NDArray[np.generic]

#: Random paths, also where nothing scatters.
PATHS: Kind = {"integrator": {"kind": "volumetric_path"}}
#: The same under majorants of many cells: grids by the same loop, all else by the one that knows everything.
FULL: Kind = {**PATHS, "majorant": {"kind": "grid", "resolution": 8}, "seed": 8}
LOOPS = {"paths": PATHS, "full loop": FULL}


def sky(radiance: Any = 1.0) -> Kind:
    return {"kind": "constant", "radiance": radiance}


def beam(irradiance: Any = 1.0, direction: Point = (0.0, 0.0, 1.0)) -> Kind:
    return {"kind": "directional", "direction": list(direction), "irradiance": irradiance}


def cube(sigma_t: Any, albedo: Any, size: float = 1.0, corner: Point = (0.0, 0.0, 0.0), **keys: Any) -> Kind:
    """A homogeneous medium in an axis-parallel cube."""
    return block(sigma_t, albedo, corner, (corner[0] + size, corner[1] + size, corner[2] + size), **keys)


def block(sigma_t: Any, albedo: Any, low: Point, high: Point, **keys: Any) -> Kind:
    shape = {"kind": "box", "min": list(low), "max": list(high)}
    return {"kind": "constant", "shape": shape, "sigma_t": sigma_t, "albedo": albedo, **keys}


def ball(sigma_t: Any, albedo: Any, radius: float = 0.5, center: Point = (0.5, 0.5, 0.5), **keys: Any) -> Kind:
    shape = {"kind": "sphere", "center": list(center), "radius": radius}
    return {"kind": "constant", "shape": shape, "sigma_t": sigma_t, "albedo": albedo, **keys}


def grid(
    folder: Path, values: Values, albedo: Any, size: float = 1.0, corner: Point = (0.0, 0.0, 0.0), **keys: Any
) -> Kind:
    """A medium of a grid [z][y][x] that fills an axis-parallel cube."""
    placed = [[size * (i == j) for j in range(3)] + [corner[i]] for i in range(3)]
    to_world = [*placed, [0.0, 0.0, 0.0, 1.0]]
    return {"kind": "grid", "file": stored(folder, values), "albedo": albedo, "to_world": to_world, **keys}


def stored(folder: Path, values: Values) -> str:
    """A file of an array."""
    file = folder / f"{len(list(folder.iterdir()))}.npy"
    np.save(file, values)
    return str(file)


def noise(*shape: int) -> NDArray[np.float32]:
    """Uniform from 0 to 1, always the same."""
    return np.random.default_rng(3).random(shape, dtype=np.float32)


def parallel(origin: Point, target: Point, height: float, up: Point = (0.0, -1.0, 0.0)) -> Kind:
    points = {"origin": list(origin), "target": list(target), "up": list(up)}
    return {"kind": "orthographic", **points, "height": height}


def seen(*volumes: Kind, size: float = 1.0, corner: Point = (0.0, 0.0, 0.0), **keys: Any) -> Description:
    """Media in an axis-parallel cube that fills the picture, seen along +z by parallel rays, under a sky of 1. Columns
    of pixels rise with x, rows with y."""
    x, y, z = corner
    half = size / 2
    camera = parallel((x + half, y + half, z - size), (x + half, y + half, z + half), size)
    film = {"width": 8, "height": 8}
    return {"camera": camera, "volumes": list(volumes), "lights": [sky()], "film": film, "seed": 7, **keys}


def square(pixels: int) -> Kind:
    return {"film": {"width": pixels, "height": pixels}}


def decades(low: int, high: int, step: int = 1) -> list[float]:
    return [float(f"1e{n}") for n in range(low, high + 1, step)]


def field_of_view(half_height: float, distance: float) -> float:
    """In degrees."""
    return math.degrees(2 * math.atan(half_height / distance))
