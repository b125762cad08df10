"""What the readers of dense arrays share: shapes, types and places."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from woodcock.formats.grid import Data, GridInfo, VolumeError, check_size

#: A file of one array without a name for it.
NAME = "density"

Matrix = npt.NDArray[np.float64]
Values = npt.NDArray[Any]


def check_shape(shape: Sequence[int]) -> None:
    """Refuses an array indexed [z][y][x] or [z][y][x][3] that is too large."""
    check_size(shape[2::-1], "holds", math.prod(shape[3:]))


def values_at(data: Data | bytearray, start: int, shape: Sequence[int], dtype: np.dtype[Any]) -> Values:
    """A view of an array of `shape`, the last index fastest, that begins at byte `start`."""
    count = math.prod(shape)
    size, found = count * dtype.itemsize, max(0, len(data) - start)
    if found < size:
        raise VolumeError(f"is cut short: its header announces {size} bytes of values, {found} follow")
    flat: Values = np.frombuffer(data, dtype, count, start)
    return flat.reshape(shape)


def keep(array: Values, *, owned: bool = False) -> Values:
    """C-contiguous, native, in one of the three types of a Grid; a copy, unless the array's memory is `owned`.

    Half, float and unsigned bytes keep their precision (booleans are 0 and 1); every other type becomes float.
    """
    kind, size = array.dtype.kind, array.dtype.itemsize
    if kind == "b":  # as bytes first: a damaged file may hold others than 0 and 1
        return np.ascontiguousarray(array.view(np.uint8) != 0).view(np.uint8)
    kept: npt.DTypeLike = np.float32
    if (kind, size) in (("u", 1), ("f", 2)):
        kept = np.uint8 if kind == "u" else np.float16
    with np.errstate(over="ignore", invalid="ignore"):
        values = np.array(array, dtype=kept, order="C", copy=None if owned else True)
    if (kind, size) == ("f", 8) and bool((np.isinf(values) & np.isfinite(array)).any()):
        raise VolumeError("holds values too large for a 32-bit float")
    return values


def scaled(array: Values, slope: float, offset: float) -> Values:
    """slope × values + offset, in float64 until it is a float; slice by slice, to bound the memory."""
    values = np.empty(array.shape, np.float32)
    with np.errstate(over="ignore", invalid="ignore"):
        for source, target in zip(array, values, strict=True):
            target[...] = source.astype(np.float64) * slope + offset
    if bool((~np.isfinite(values) & np.isfinite(array)).any()):
        raise VolumeError("holds values that its scale makes too large for a 32-bit float")
    return values


def info(name: str, shape: Sequence[int], dtype: np.dtype[Any]) -> GridInfo:
    """Of an array indexed [z][y][x] or [z][y][x][3]; every voxel counts as active."""
    z, y, x = shape[:3]
    return GridInfo(name, dtype.name + ("[3]" if len(shape) == 4 else ""), (x, y, z), x * y * z)


def unit_cube(shape: Sequence[int]) -> Matrix:
    """index_to_world of an array of `shape` [z][y][x] that fills the unit cube."""
    z, y, x = shape[:3]
    return np.diag((1 / x, 1 / y, 1 / z, 1.0))


def from_samples(samples_to_world: Matrix) -> Matrix:
    """index_to_world from an affine map whose voxel [k][j][i] has its sample at (i, j, k): here it is half a voxel
    further. Raises VolumeError for a map that cannot be inverted."""
    cell_to_sample = np.eye(4)
    cell_to_sample[:3, 3] = -0.5
    with np.errstate(all="ignore"):
        index_to_world: Matrix = samples_to_world @ cell_to_sample
        size = abs(np.linalg.det(index_to_world[:3, :3])) if np.isfinite(index_to_world).all() else 0.0
    if not 0 < size < math.inf:
        raise VolumeError("has a transform that is no affine map that can be inverted")
    return index_to_world
