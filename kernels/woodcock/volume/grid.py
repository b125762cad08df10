"""Density on a regular grid, trilinear, in a box or wherever its file and the scene place it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from woodcock.formats import MAX_VOXELS, Grid, GridInfo, VolumeError
from woodcock.scene import GridVolume
from woodcock.space import Array, Space
from woodcock.volume.field import BRICK, STORED, Buffer

FIELDS = {
    "to_local": "affine",
    "size": "vector3",
    "albedo": "colour",
    "width": "int",
    "height": "int",
    "depth": "int",
    "bricks_x": "int",
    "bricks_y": "int",
    "relative": "float",
}


def to_scene(volume: GridVolume, grid: Grid) -> Array:
    """(4, 4) from local space, one unit a voxel, to the scene."""
    return np.array(volume.to_world) @ grid.index_to_world


def check_info(info: GridInfo) -> None:
    """Raises VolumeError for a grid that cannot be a density by what its file says of it."""
    if info.voxels == 0:
        raise VolumeError(_empty(info.name))
    if math.prod(info.shape) > MAX_VOXELS:
        size = " × ".join(map(str, info.shape))
        raise VolumeError(f"grid {info.name!r} spans {size} voxels; {MAX_VOXELS} are the most")


def check(grid: Grid, file: str) -> float:
    """The largest density, of any channel. Raises VolumeError for densities that are negative, not finite, or nowhere
    above 0."""
    high = check_values(grid, file, "densities")
    if high == 0:
        raise VolumeError(f"{file}: {_empty(grid.name)}")
    return high


def check_values(grid: Grid, file: str, what: str, most: float = np.inf, *, colours: bool = True) -> float:
    """The largest value, of any channel. Raises VolumeError for ones that are negative, not finite or above `most`."""
    if grid.values.ndim == 4 and not (colours and grid.values.shape[3] == 3):
        raise VolumeError(f"{file}: grid {grid.name!r} holds vectors; {what} are numbers")
    low, high = float(grid.values.min()), float(grid.values.max())
    if not (np.isfinite(low) and np.isfinite(high)):
        raise VolumeError(
            f"{file}: grid {grid.name!r} holds values that are not finite{_where(~np.isfinite(grid.values))}"
        )
    if low < 0:
        raise VolumeError(
            f"{file}: grid {grid.name!r} holds negative {what}, down to {low:g}{_where(grid.values == low)}"
        )
    if high > most:
        raise VolumeError(
            f"{file}: grid {grid.name!r} holds {what} above {most:g}, up to {high:g}{_where(grid.values == high)}"
        )
    return high


def _empty(name: str) -> str:
    return f"grid {name!r} is empty; a density needs a voxel above 0"


def _where(mask: NDArray[np.bool_]) -> str:
    z, y, x = np.unravel_index(int(np.argmax(mask)), mask.shape)[:3]
    return f", first at voxel ({x}, {y}, {z})"


def storage(values: NDArray[np.generic]) -> str:
    """The narrowest of uint8, half and float that holds every value exactly: compact, and no error to state."""
    if values.dtype == np.uint8:
        return "uint8"
    if values.dtype == np.float16:
        return "half"
    with np.errstate(over="ignore", invalid="ignore"):
        if np.array_equal(values, values.astype(np.uint8)):
            return "uint8"
        if np.array_equal(values, values.astype(np.float16)):
            return "half"
    return "float"


def bricks(values: NDArray[np.generic], kind: str) -> Buffer:
    """(depth, height, width) -> bricks of 4³, one layer of them at a time, the border padded with its own values;
    halves as bits."""
    dtype = STORED[kind]
    factor = lift(float(values.max())) if kind == "float" else 1.0
    depth, height, width = (-(-n // BRICK) for n in values.shape)
    padding = [(0, -n % BRICK) for n in values.shape[1:]]

    def pieces() -> Iterator[NDArray[np.generic]]:
        for first in range(0, values.shape[0], BRICK):
            layers = values[first : first + BRICK].astype(dtype, copy=False)
            padded = np.pad(layers, [(0, BRICK - len(layers)), *padding], mode="edge")
            if factor != 1:
                padded = padded * np.float32(factor)
            split = padded.reshape(BRICK, height, BRICK, width, BRICK).transpose(1, 3, 0, 2, 4)
            run: NDArray[np.generic] = np.ascontiguousarray(split).reshape(-1)
            yield run.view(np.uint16) if kind == "half" else run

    return Buffer(np.dtype(np.uint16) if kind == "half" else dtype, depth * height * width * BRICK**3, pieces)


def lift(largest: float) -> float:
    """What floats are stored times, so that the largest has an inverse with all its digits."""
    return 2.0**64 if 0 < largest < 2.0**-126 else 2.0**-64 if largest > 2.0**126 else 1.0


def record(volume: GridVolume, grid: Grid, largest: float, space: Space) -> dict[str, Array | float | int]:
    depth, height, width = grid.values.shape
    return {
        "to_local": space.affine(to_scene(volume, grid)),
        "size": np.array([width, height, depth], float),
        "albedo": np.atleast_1d(np.array(volume.albedo)),
        "width": width,
        "height": height,
        "depth": depth,
        "bricks_x": -(-width // BRICK),
        "bricks_y": -(-height // BRICK),
        "relative": 1 / (largest * lift(largest)) if largest > 0 else 0.0,
    }


def density(volume: GridVolume, grid: Grid, points: Array) -> Array:
    """Float64 oracle: σ_t at points (..., 3) of the scene, 0 outside; (..., 3) for a grid or a scale of colours."""
    values = interpolated(grid, to_scene(volume, grid), points, nearest=volume.interpolation == "nearest")
    if isinstance(volume.scale, tuple) and grid.values.ndim == 3:
        values = values[..., None]
    return np.asarray(values * np.array(volume.scale))


def interpolated(grid: Grid, placement: Array, points: Array, *, nearest: bool = False) -> Array:
    """Float64 oracle: a grid's values at points (..., 3), placed by (4, 4) from its voxels; 0 outside."""
    local = np.linalg.inv(placement)
    p = points @ local[:3, :3].T + local[:3, 3]
    size = np.array(grid.values.shape[2::-1])
    inside = np.all((p >= 0) & (p <= size), axis=-1)
    base = np.floor(p if nearest else p - 0.5)
    fraction = np.zeros_like(p) if nearest else p - 0.5 - base
    channels = grid.values.shape[3:]
    total = np.zeros((*points.shape[:-1], *channels))
    for corner in np.ndindex(2, 2, 2):
        x, y, z = np.moveaxis(np.clip(base + corner, 0, size - 1).astype(int), -1, 0)
        weight = np.prod(np.where(np.array(corner) == 1, fraction, 1 - fraction), axis=-1)
        weight = np.where(inside, weight, 0.0)
        total += weight.reshape(weight.shape + (1,) * len(channels)) * grid.values[z, y, x].astype(np.float64)
    return total
