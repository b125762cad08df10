"""NumPy's .npy: one array, indexed [z][y][x] or [z][y][x][3], of booleans, integers or floats.

The format is defined in numpy.lib.format: magic, version, length of the header, the header as a Python literal, the
values. Nothing is ever unpickled. Half, float and unsigned bytes keep their precision (booleans are 0 and 1); every
other type becomes float.
"""

from __future__ import annotations

import ast
import math
import re
from typing import Any

import numpy as np
import numpy.typing as npt

from woodcock.formats.grid import Grid, GridInfo, VolumeError, check_size, choose, quoted

MAGIC = b"\x93NUMPY"

#: An array has no name in the file.
NAME = "density"

_MAX_HEADER = 10_000  # as numpy has it: what a literal costs to parse is not linear in its length


def read(data: bytes, name: str | None) -> Grid:
    """The array in `data`, the whole of a file; it fills the unit cube. Raises VolumeError."""
    choose((NAME,), name)
    values = _keep(_array(data))
    z, y, x = values.shape[:3]
    return Grid(NAME, values, np.diag((1 / x, 1 / y, 1 / z, 1.0)), placed=False)


def list_grids(data: bytes) -> tuple[GridInfo, ...]:
    """The one array; every voxel counts as active. Raises VolumeError."""
    array = _array(data)
    z, y, x = array.shape[:3]
    vector = "" if array.ndim == 3 else "[3]"
    return (GridInfo(NAME, array.dtype.name + vector, (x, y, z), x * y * z),)


def _array(data: bytes) -> npt.NDArray[Any]:
    """A view of the values, in their own type and order."""
    shape, dtype, fortran_order, offset = _header(data)
    check_size(shape[2::-1], "holds")
    size = math.prod(shape) * dtype.itemsize
    if len(data) - offset < size:
        raise VolumeError(f"is cut short: its header announces {size} bytes of values, {len(data) - offset} follow")
    flat: npt.NDArray[Any] = np.frombuffer(data, dtype, math.prod(shape), offset)
    return flat.reshape(shape, order="F" if fortran_order else "C")


def _header(data: bytes) -> tuple[tuple[int, ...], np.dtype[Any], bool, int]:
    version = data[6:8]
    if version not in (b"\x01\x00", b"\x02\x00", b"\x03\x00"):
        raise VolumeError(f"has an unknown .npy version {'.'.join(map(str, version))}")
    start = 10 if version[0] == 1 else 12
    length = int.from_bytes(data[8:start], "little")
    if len(data) < start + length:
        raise VolumeError("is cut short in its .npy header")
    if length > _MAX_HEADER:
        raise VolumeError(f"has a .npy header of {length} bytes, more than {_MAX_HEADER}")
    try:
        header = ast.literal_eval(data[start : start + length].decode("latin-1").strip())
        descr, fortran_order, shape = header["descr"], header["fortran_order"], header["shape"]
    except (ValueError, SyntaxError, TypeError, KeyError, MemoryError, RecursionError):
        raise VolumeError("has a damaged .npy header") from None
    if not (isinstance(descr, str) and re.fullmatch(r"[<>|=](b1|[iu][1248]|f[248])", descr)):
        kind = quoted(descr) if isinstance(descr, str) else "records"
        raise VolumeError(f"must hold booleans, integers or floats, not {kind}")
    if not (isinstance(shape, tuple) and all(type(n) is int and 0 <= n < 1 << 63 for n in shape)):
        raise VolumeError("has a damaged shape in its .npy header")
    if not (len(shape) == 3 or (len(shape) == 4 and shape[3] == 3)) or 0 in shape:
        raise VolumeError(
            f"must be indexed [z][y][x] or [z][y][x][3] and not be empty, but has the shape {shape}"[:200]
        )
    return shape, np.dtype(descr), bool(fortran_order), start + length


def _keep(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """C-contiguous, native, in one of the three types of a Grid."""
    kind, size = array.dtype.kind, array.dtype.itemsize
    if kind == "b":  # as bytes first: a damaged file may hold others than 0 and 1
        return np.ascontiguousarray(array.view(np.uint8) != 0).view(np.uint8)
    if (kind, size) == ("u", 1):
        return np.ascontiguousarray(array)
    kept = np.float16 if (kind, size) == ("f", 2) else np.float32
    with np.errstate(over="ignore", invalid="ignore"):
        values = np.ascontiguousarray(array, dtype=kept)
    if size == 8 and kind == "f" and bool((np.isinf(values) & np.isfinite(array)).any()):
        raise VolumeError("holds values too large for a 32-bit float")
    return values
