"""What an uploaded file holds, found out by reading it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from woodcock import formats, picture
from woodcock.formats import VolumeError, mesh
from woodcock.image import ImageError

UNREADABLE = (
    "is no file that can be read; volumes (OpenVDB, NanoVDB, NumPy's .npy and .npz, Mitsuba's .vol, NRRD, NIfTI), "
    "meshes (PLY, OBJ, glTF) and pictures (OpenEXR, Radiance HDR) can"
)


class UnreadableFile(ValueError):  # noqa: N818 - it says what was found
    """The text says why, without the file's name."""


def read(path: Path) -> dict[str, Any]:
    """The columns of tables.volumes that tell what the file holds. Raises UnreadableFile."""
    try:
        if formats.recognises(path):
            return _columns("volume", grids=[asdict(grid) for grid in formats.list_grids(path)])
        if mesh.recognises(path):
            return _columns("mesh", triangles=len(mesh.read_mesh(path).faces))
        if picture.recognises(path):
            height, width = picture.read_picture(path).shape[:2]
            return _columns("picture", width=width, height=height)
    except (VolumeError, ImageError) as error:
        # The reader names the temporary file, of which the sender knows nothing.
        raise UnreadableFile(str(error).removeprefix(f"{path}: ").replace(str(path), "the file")) from None
    raise UnreadableFile(UNREADABLE)


def _columns(type_: str, **found: Any) -> dict[str, Any]:
    if found.get("grids") == []:
        raise UnreadableFile("holds no grid")
    return {"type": type_, "grids": [], "triangles": None, "width": None, "height": None, **found}
