"""NumPy's .npy: one array, indexed [z][y][x] or [z][y][x][3], of booleans, integers or floats.

The format is defined in numpy.lib.format: magic, version, length of the header, the header as a Python literal, the
values. Nothing is ever unpickled.
"""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from woodcock.formats.dense import NAME, Values, check_shape, info, keep, unit_cube, values_at
from woodcock.formats.grid import Data, File, Grid, GridInfo, VolumeError, choose, quoted

MAGIC = b"\x93NUMPY"

_MAX_HEADER = 10_000  # as numpy has it: what a literal costs to parse is not linear in its length

#: Bytes from the beginning that hold any header.
LONGEST_HEADER = 12 + _MAX_HEADER


@dataclass(frozen=True)
class Header:
    """What an array is; its values begin at byte `start`."""

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    fortran_order: bool
    start: int


def recognises(file: File) -> bool:
    return file.data[: len(MAGIC)] == MAGIC


def read(file: File, name: str | None) -> Grid:
    """The array; it fills the unit cube. Raises VolumeError."""
    choose((NAME,), name)
    values = keep(array(file.data, header(file.data)))
    return Grid(NAME, values, unit_cube(values.shape), placed=False)


def list_grids(file: File) -> tuple[GridInfo, ...]:
    """The one array; every voxel counts as active. Raises VolumeError."""
    found = header(file.data)
    array(file.data, found)
    return (info(NAME, found.shape, found.dtype),)


def array(data: Data | bytearray, found: Header, offset: int = 0) -> Values:
    """A view of the values of an array that begins at byte `offset`, in their own type and order."""
    shape = found.shape
    check_shape(shape)
    if found.fortran_order:  # the same bytes are an array in C's order, its indices reversed
        transposed = values_at(data, offset + found.start, shape[::-1], found.dtype)
        return transposed.T
    return values_at(data, offset + found.start, shape, found.dtype)


def header(data: Data | bytearray, offset: int = 0) -> Header:
    """The header of an array that begins at byte `offset`. Raises VolumeError for one that is no volume."""
    if data[offset : offset + len(MAGIC)] != MAGIC:
        raise VolumeError("is no .npy array")
    version = data[offset + 6 : offset + 8]
    if version not in (b"\x01\x00", b"\x02\x00", b"\x03\x00"):
        raise VolumeError(f"has an unknown .npy version {'.'.join(map(str, version))}")
    start = 10 if version[0] == 1 else 12
    length = int.from_bytes(data[offset + 8 : offset + start], "little")
    if len(data) < offset + start + length:
        raise VolumeError("is cut short in its .npy header")
    if length > _MAX_HEADER:
        raise VolumeError(f"has a .npy header of {length} bytes, more than {_MAX_HEADER}")
    text = data[offset + start : offset + start + length].decode("latin-1").strip()
    return _parsed(text, start + length)


def _parsed(text: str, start: int) -> Header:
    try:
        literal = ast.literal_eval(text)
        descr, fortran_order, shape = literal["descr"], literal["fortran_order"], literal["shape"]
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
    return Header(shape, np.dtype(descr), bool(fortran_order), start)
