"""Mitsuba's .vol: one dense array in a box.

Version 3, as the manual of Mitsuba defines it for `gridvolume`, little-endian: `VOL`, the version, the type of the
values, x, y, z, channels, the box (all three lower bounds, then the upper ones), the values, x fastest but for the
channels. The samples are taken to lie in the middles of cells that fill the box, as Mitsuba 3 has it.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from woodcock.formats.dense import NAME, Values, check_shape, info, keep, scaled, values_at
from woodcock.formats.grid import File, Grid, GridInfo, VolumeError, choose

MAGIC = b"VOL"

_HEADER = struct.Struct("<3sB5i6f")
_TYPES: dict[int, np.dtype[Any]] = {1: np.dtype("<f4"), 2: np.dtype("<f2"), 3: np.dtype("u1")}


def recognises(file: File) -> bool:
    return file.data[: len(MAGIC)] == MAGIC


def read(file: File, name: str | None) -> Grid:
    """The array, in the box that the file states; unsigned bytes stand for 0 to 1. Raises VolumeError."""
    choose((NAME,), name)
    array, box = _array(file)
    low, high = np.array(box[:3]), np.array(box[3:])
    if not (np.isfinite(box).all() and (high > low).all()):
        raise VolumeError(f"has a box from {tuple(box[:3])} to {tuple(box[3:])}: it must have a volume")
    index_to_world = np.eye(4)
    index_to_world[:3, :3] = np.diag((high - low) / array.shape[2::-1])
    index_to_world[:3, 3] = low
    values = scaled(array, 1 / 255, 0.0) if array.dtype == np.uint8 else keep(array)
    return Grid(NAME, values, index_to_world, placed=True)


def list_grids(file: File) -> tuple[GridInfo, ...]:
    """The one array; every voxel counts as active. Raises VolumeError."""
    array, _ = _array(file)
    return (info(NAME, array.shape, array.dtype),)


def _array(file: File) -> tuple[Values, list[float]]:
    """A view of the values, indexed [z][y][x] or [z][y][x][3], and the box."""
    if len(file.data) < _HEADER.size:
        raise VolumeError("is cut short in its header")
    _, version, kind, x, y, z, channels, *box = _HEADER.unpack_from(file.data)
    if version != 3:
        raise VolumeError(f"is of .vol version {version}; only 3 can be read")
    if kind not in _TYPES:
        raise VolumeError(f"holds values of type {kind}; 1 (float32), 2 (float16) and 3 (uint8) can be read")
    if min(x, y, z) < 1 or channels not in (1, 3):
        raise VolumeError(f"holds {x} × {y} × {z} voxels of {channels} channels; it must hold some, of 1 or 3")
    shape = (z, y, x, 3) if channels == 3 else (z, y, x)
    check_shape(shape)
    return values_at(file.data, _HEADER.size, shape, _TYPES[kind]), box
