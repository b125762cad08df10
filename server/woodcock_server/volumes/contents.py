"""What an uploaded file holds, found out by reading it.

`python -m woodcock_server.volumes.contents MEMORY SECONDS FILE`, the child process of `parser.py`, says so as JSON;
with the position of a grid in the file after it, what that grid looks like.
"""

from __future__ import annotations

import json
import math
import resource
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from woodcock import formats
from woodcock.formats import MAX_VOXELS, VolumeError, mesh
from woodcock_server.volumes.samples import sample

UNREADABLE = (
    "is no file that can be read; volumes (OpenVDB, NanoVDB, NumPy's .npy and .npz, Mitsuba's .vol, NRRD, NIfTI), "
    "meshes (PLY, OBJ, glTF) and pictures (OpenEXR, Radiance HDR) can"
)


class UnreadableFile(ValueError):  # noqa: N818 - it says what was found
    """The text says why, without the file's name."""


def read(path: Path) -> dict[str, Any]:
    """The fields of schemas.Contents. Raises UnreadableFile, and MemoryError."""
    with _faults_of(path):
        if formats.recognises(path):
            return {"type": "volume", "grids": _grids(path)}
        if mesh.recognises(path):
            return {"type": "mesh", "triangles": len(mesh.read_mesh(path).faces)}
    return _picture(path)


def look(path: Path, position: int) -> dict[str, Any]:
    """The fields of samples.Samples. Raises UnreadableFile, and MemoryError."""
    with _faults_of(path):
        return sample(path, position)


@contextmanager
def _faults_of(path: Path) -> Iterator[None]:
    try:
        yield
    except VolumeError as error:
        if isinstance(error.__cause__, MemoryError):
            raise error.__cause__ from None
        raise UnreadableFile(_sentence(path, error)) from None


def _grids(path: Path) -> list[dict[str, Any]]:
    grids = formats.list_grids(path)
    if not grids:
        raise UnreadableFile("holds no grid")
    if all(math.prod(grid.shape) > MAX_VOXELS for grid in grids):
        size = " × ".join(map(str, grids[0].shape))
        raise UnreadableFile(f"holds no grid of {MAX_VOXELS} voxels or fewer; the first spans {size}")
    return [asdict(grid) for grid in grids]


def _picture(path: Path) -> dict[str, Any]:
    # Only now: what reads pictures takes longer to import than all the rest.
    from woodcock import picture
    from woodcock.image import ImageError

    if not picture.recognises(path):
        raise UnreadableFile(UNREADABLE)
    try:
        height, width = picture.read_picture(path).shape[:2]
    except ImageError as error:
        raise UnreadableFile(_sentence(path, error)) from None
    return {"type": "picture", "width": width, "height": height}


def _sentence(path: Path, error: Exception) -> str:
    # The reader names the temporary file, of which the sender knows nothing.
    return str(error).removeprefix(f"{path}: ").replace(str(path), "the file")


def confine(memory: int, seconds: int) -> None:
    """Of this process: at most so many bytes and seconds of a processor, no file written, no core dumped."""
    # Not RLIMIT_AS: the file is mapped and may be larger than what reading it takes, and libraries reserve addresses
    # that they never use. RLIMIT_DATA counts the memory that is the process's own.
    for kind, soft, hard in (
        (resource.RLIMIT_DATA, memory, memory),
        (resource.RLIMIT_CPU, seconds, seconds + 1),  # by a signal of its own before it is killed
        (resource.RLIMIT_FSIZE, 0, 0),
        (resource.RLIMIT_CORE, 0, 0),
    ):
        most = resource.getrlimit(kind)[1]
        if most != resource.RLIM_INFINITY:
            soft, hard = min(soft, most), min(hard, most)
        resource.setrlimit(kind, (soft, hard))


def _serve(memory: str, seconds: str, file: str, position: str | None = None) -> None:
    """The child: writes what `parser.Answer` says to stdout."""
    confine(int(memory), int(seconds))
    answer: dict[str, Any]
    try:
        answer = {"contents": read(Path(file)) if position is None else look(Path(file), int(position))}
    except UnreadableFile as error:
        answer = {"fault": str(error)}
    except MemoryError:
        most = int(memory) >> 20
        answer = {"fault": f"takes more than {most} MiB of memory to read, the most that a file may take here"}
    except Exception as error:
        fault = f"cannot be read: its reader failed ({type(error).__name__})"
        answer = {"fault": fault, "error": traceback.format_exc()}
    json.dump(answer, sys.stdout)


if __name__ == "__main__":
    _serve(*sys.argv[1:])
