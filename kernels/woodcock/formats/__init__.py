"""Volumes in: one file a format, chosen by what the file begins with, not by its name.

    vdb.py   OpenVDB (file versions 222 to 225): trees of float and vec3s, half or full precision
    npy.py   NumPy arrays, indexed [z][y][x] or [z][y][x][3]

Every fault of a file is one VolumeError that names the file; no size that a file states is believed before it is
checked against the bytes that are there or against MAX_VOXELS.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from woodcock.formats import npy, vdb
from woodcock.formats.grid import MAX_VOXELS, Grid, GridInfo, VolumeError

__all__ = ["MAX_VOXELS", "Grid", "GridInfo", "VolumeError", "list_grids", "read_grid"]


def read_grid(path: Path, name: str | None = None) -> Grid:
    """The grid `name` of a file; without a name the one called `density`, or the only one there is.

    Raises VolumeError, whose text starts with the path.
    """
    with _faults_of(path):
        reader, data = _open(path)
        grid: Grid = reader.read(data, name)
        return grid


def list_grids(path: Path) -> tuple[GridInfo, ...]:
    """What grids a file holds, those that `read_grid` refuses included, in the file's order. Raises VolumeError."""
    with _faults_of(path):
        reader, data = _open(path)
        grids: tuple[GridInfo, ...] = reader.list_grids(data)
        return grids


def _open(path: Path) -> tuple[ModuleType, bytes]:
    if "\0" in str(path):
        raise VolumeError("is no name of a file")
    if path.exists() and not path.is_file():
        raise VolumeError("is not a file")
    with path.open("rb") as file:
        start = file.read(len(vdb.MAGIC))
        for reader in (vdb, npy):
            if start.startswith(reader.MAGIC):
                file.seek(0)
                return reader, file.read()
    raise VolumeError("is no volume that can be read; OpenVDB (.vdb) and NumPy (.npy) files can")


@contextmanager
def _faults_of(path: Path) -> Iterator[None]:
    try:
        yield
    except VolumeError as error:
        raise VolumeError(f"{path}: {error}") from None
    except OSError as error:
        raise VolumeError(f"{path}: {error.strerror}") from None
    except MemoryError:
        raise VolumeError(f"{path}: needs more memory than there is") from None
