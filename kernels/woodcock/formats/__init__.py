"""Volumes in: one file a format, chosen by what the file begins with, not by its name.

    vdb.py     OpenVDB (file versions 222 to 225): trees of float and vec3s, half or full precision
    nanovdb.py NanoVDB (.nvdb, versions 32.x): trees of float, double, half, vec3f and the quantised floats
    npy.py     NumPy arrays, indexed [z][y][x] or [z][y][x][3]
    npz.py     NumPy's archives of such arrays: a grid each
    vol.py     Mitsuba's .vol (version 3): float32, float16, uint8, in the box that the file states
    nrrd.py    NRRD, raw, gzip or bzip2, values in the same file or beside it
    nifti.py   NIfTI-1 and -2 (.nii, .nii.gz)
    raw.py     bare values, the one format that goes by the name: `bonsai_256x256x256_uint8.raw`

Every fault of a file is one VolumeError that names the file; no size that a file states is believed before it is
checked against the bytes that are there or against MAX_VOXELS.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from woodcock.formats import nanovdb, nifti, npy, npz, nrrd, raw, vdb, vol
from woodcock.formats.grid import MAX_VOXELS, File, Grid, GridInfo, VolumeError, opened

__all__ = ["MAX_VOXELS", "Grid", "GridInfo", "VolumeError", "list_grids", "read_grid", "recognises"]

_READERS = (vdb, nanovdb, npy, npz, vol, nrrd, nifti, raw)


def recognises(path: Path) -> bool:
    """Is the file a volume by what it begins with? Raises OSError, and VolumeError for what is no file."""
    file = opened(path)
    return any(reader.recognises(file) for reader in _READERS)


def read_grid(path: Path, name: str | None = None) -> Grid:
    """The grid `name` of a file; without a name the one called `density`, or the only one there is.

    Raises VolumeError, whose text starts with the path.
    """
    with _faults_of(path):
        reader, file = _open(path)
        grid: Grid = reader.read(file, name)
        return grid


def list_grids(path: Path) -> tuple[GridInfo, ...]:
    """What grids a file holds, those that `read_grid` refuses included, in the file's order. Raises VolumeError."""
    with _faults_of(path):
        reader, file = _open(path)
        grids: tuple[GridInfo, ...] = reader.list_grids(file)
        return grids


def _open(path: Path) -> tuple[ModuleType, File]:
    file = opened(path)
    for reader in _READERS:
        if reader.recognises(file):
            return reader, file
    raise VolumeError(
        "is no volume that can be read; OpenVDB (.vdb), NanoVDB (.nvdb), NumPy (.npy, .npz), Mitsuba (.vol), NRRD, "
        "NIfTI files and raw values (name_128x64x32_uint8.raw) can"
    )


@contextmanager
def _faults_of(path: Path) -> Iterator[None]:
    try:
        yield
    except VolumeError as error:
        raise VolumeError(f"{path}: {error}") from None
    except OSError as error:
        raise VolumeError(f"{path}: {error.strerror}") from None
    except MemoryError as error:
        raise VolumeError(f"{path}: needs more memory than there is") from error
