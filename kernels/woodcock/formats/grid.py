"""What every reader returns."""

from __future__ import annotations

import mmap
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

#: Most voxels of a dense array: 32 GiB of float.
MAX_VOXELS = 1 << 33
#: Most grids of a file.
MAX_GRIDS = 10_000


class VolumeError(ValueError):
    """A file that cannot be read as a volume; the text names the file and what is wrong."""


Data: TypeAlias = bytes | mmap.mmap


@dataclass(frozen=True)
class File:
    """What a reader reads. The bytes are mapped, not loaded: slices are copies, views are not, and no Grid may keep a
    view, because to look at a mapped file that has been cut short since kills the process."""

    path: Path
    data: Data


def opened(path: Path) -> File:
    """Raises VolumeError or OSError."""
    if "\0" in str(path):
        raise VolumeError("is no name of a file")
    if path.exists() and not path.is_file():
        raise VolumeError("is not a file")
    with path.open("rb") as stream:
        try:
            return File(path, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ))
        except ValueError:  # of a file that is empty
            return File(path, b"")


@dataclass(frozen=True)
class Grid:
    """Samples on a regular grid.

    `values` is C-contiguous, float32, float16 or uint8 as the file has it, indexed [z][y][x], or [z][y][x][3] for
    vectors. Voxel [k][j][i] occupies the cell [i, i+1] × [j, j+1] × [k, k+1] and its sample lies in the middle.
    `index_to_world` (4×4 float64, for column vectors, affine) takes these coordinates to the world. `placed` says
    that the file gave it; otherwise it maps the whole array to the unit cube. Beyond the array everything is
    `background`.
    """

    name: str
    values: npt.NDArray[Any]
    index_to_world: npt.NDArray[np.float64]
    placed: bool
    background: float = 0.0


@dataclass(frozen=True)
class GridInfo:
    """A grid in a file: `type` is that of a value (`float`, `half`, `vec3s` …), `shape` (x, y, z) the size of the
    bounding box of the active voxels, `voxels` their number."""

    name: str
    type: str
    shape: tuple[int, int, int]
    voxels: int


def choose(names: Sequence[str], name: str | None) -> int:
    """Position of the grid that is meant: `name`; without one `density`, or the only one."""
    known = ", ".join(map(quoted, names[:20])) + " …" * (len(names) > 20)
    if not names:
        raise VolumeError("holds no grid")
    if name is not None:
        if name not in names:
            raise VolumeError(f"has no grid {quoted(name)}; it has {known}")
        return names.index(name)
    if "density" in names:
        return names.index("density")
    if len(names) > 1:
        raise VolumeError(f'has no grid "density" and several others: name one of {known}')
    return 0


def quoted(text: str) -> str:
    """A text out of a file, fit for an error message: short and on one line."""
    shown = "".join(letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in text[:60])
    return f'"{shown}"' if len(text) <= 60 else f'"{shown}…"'


def check_size(shape: Sequence[int], where: str, channels: int = 1) -> None:
    """Refuses a dense array of `shape` (x, y, z) voxels, of so many numbers each, that is larger than MAX_VOXELS, or,
    as floats, than memory."""
    x, y, z = shape
    if x * y * z > MAX_VOXELS:
        raise VolumeError(f"{where} {x} × {y} × {z} voxels, more than the {MAX_VOXELS} that are allowed")
    if 4 * channels * x * y * z > memory():
        raise VolumeError(
            f"{where} {x} × {y} × {z} voxels, more than the {memory() >> 20} MiB of this machine's memory hold"
        )


def check_bytes(size: int, what: str) -> None:
    """Refuses what a file says to take so many bytes, if that is more than memory."""
    if size > memory():
        raise VolumeError(f"{what} {size} bytes, more than the {memory() >> 20} MiB of this machine's memory hold")


def memory() -> int:
    """Bytes of this machine."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
