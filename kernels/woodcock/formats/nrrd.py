"""NRRD: a text header (`nrrd_header.py`) and the values, behind it or in one other file of the same folder.

Values are raw, or packed by gzip or bzip2, the first axis fastest. Three axes are x, y and z of the grid, a fourth of
size 3 holds vectors.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from woodcock.formats.dense import NAME, Values, from_samples, info, keep, unit_cube, values_at
from woodcock.formats.grid import Data, File, Grid, GridInfo, VolumeError, choose, opened, quoted
from woodcock.formats.nrrd_header import MAGIC, PACKED, Header, parse
from woodcock.formats.packed import check_packed, unpack


def recognises(file: File) -> bool:
    return file.data[: len(MAGIC)] == MAGIC


def read(file: File, name: str | None) -> Grid:
    """The array. Raises VolumeError."""
    choose((NAME,), name)
    header = parse(file.data)
    values = _values(file, header)
    if header.vector_axis is not None:
        values = np.moveaxis(values, header.vector_axis, -1)
    values = keep(values, owned=header.encoding in PACKED)
    if header.samples_to_world is None:
        return Grid(NAME, values, unit_cube(values.shape), placed=False)
    return Grid(NAME, values, from_samples(header.samples_to_world), placed=True)


def list_grids(file: File) -> tuple[GridInfo, ...]:
    """The one array; every voxel counts as active. Raises VolumeError."""
    header = parse(file.data)
    data, start = _found(file, header)
    if header.encoding in PACKED:
        check_packed(len(data) - start, header.skip + header.size, PACKED[header.encoding])
    else:
        values_at(data, start, header.shape, header.dtype)
    space = [size for axis, size in enumerate(header.shape) if axis != header.vector_axis]
    return (info(NAME, space if header.vector_axis is None else [*space, 3], header.dtype),)


def _values(file: File, header: Header) -> Values:
    """In the file's own order of axes; a view of the file, unless they are packed."""
    data, start = _found(file, header)
    if header.encoding in PACKED:
        unpacked = unpack(data, start, len(data), header.skip + header.size, PACKED[header.encoding])
        return values_at(unpacked, header.skip, header.shape, header.dtype)
    return values_at(data, start, header.shape, header.dtype)


def _found(file: File, header: Header) -> tuple[Data, int]:
    """What holds the values, and where they begin, or their packed stream does."""
    data, start = file.data, header.end
    if header.data_file is not None:
        data, start = _beside(file.path, header.data_file).data, 0
    for _ in range(header.lines):
        start = data.find(b"\n", start) + 1
        if start == 0:
            raise VolumeError(f"is cut short: it does not have the {header.lines} lines that its header skips")
    if header.encoding in PACKED:
        return data, start
    return data, max(start, len(data) - header.size) if header.skip < 0 else start + header.skip


def _beside(path: Path, name: str) -> File:
    # A header may come from anyone: it may name its neighbours, but no file elsewhere.
    if name in ("", ".", "..") or set(name) & set("/\\\0"):
        raise VolumeError(f"has its values in {quoted(name)}; it must be one file of the same folder")
    try:
        return opened(path.with_name(name))
    except (OSError, VolumeError):
        raise VolumeError(f"has its values in {quoted(name)}, which cannot be read") from None
