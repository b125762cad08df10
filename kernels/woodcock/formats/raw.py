"""Bare values, x fastest, described by the file's name as Open SciVis does: `bonsai_256x256x256_uint8.raw`.

Whatever stands before, the name ends in the numbers of voxels along x, y and z and the type of a value. More than one
byte a value is little-endian, unless `_be` follows the type. Nothing else says what such a file is, so one that has
lost its name, by an upload say, cannot be read; the size of the file must be just that of the values.
"""

from __future__ import annotations

import math
import re

import numpy as np

from woodcock.formats.dense import NAME, Values, check_shape, info, keep, unit_cube, values_at
from woodcock.formats.grid import File, Grid, GridInfo, VolumeError, choose

_NAME = re.compile(
    r"(?:.*_)?(\d{1,9})x(\d{1,9})x(\d{1,9})_(u?int(?:8|16|32|64)|float(?:16|32|64))(_be)?\.raw", re.ASCII | re.DOTALL
)


def recognises(file: File) -> bool:
    return _NAME.fullmatch(file.path.name) is not None


def read(file: File, name: str | None) -> Grid:
    """The array; it fills the unit cube. Raises VolumeError."""
    choose((NAME,), name)
    values = keep(_array(file))
    return Grid(NAME, values, unit_cube(values.shape), placed=False)


def list_grids(file: File) -> tuple[GridInfo, ...]:
    """The one array; every voxel counts as active. Raises VolumeError."""
    array = _array(file)
    return (info(NAME, array.shape, array.dtype),)


def _array(file: File) -> Values:
    matched = _NAME.fullmatch(file.path.name)
    assert matched, "recognises() said so"
    x, y, z = map(int, matched.group(1, 2, 3))
    dtype = np.dtype(matched[4]).newbyteorder(">" if matched[5] else "<")
    if 0 in (x, y, z):
        raise VolumeError("is empty by its name")
    check_shape((z, y, x))
    size = math.prod((x, y, z)) * dtype.itemsize
    if len(file.data) != size:
        raise VolumeError(f"must have {size} bytes by its name, but has {len(file.data)}")
    return values_at(file.data, 0, (z, y, x), dtype)
