"""Does a scene name files that were uploaded, each of the type that its place needs?"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

from pydantic import BaseModel
from sqlalchemy import RowMapping

from woodcock.formats import GridInfo, VolumeError
from woodcock.formats.grid import choose
from woodcock.image import ImageError
from woodcock.light.image import check_size
from woodcock.scene import BlackbodyEmission, GridVolume, ImageLight, MeshShape, MeshSurface, Scene
from woodcock.volume.grid import check_info
from woodcock_server.problems import Fault, InvalidRequest

#: The row of an uploaded file by its id, None where there is none.
Find: TypeAlias = Callable[[str], RowMapping | None]

FILE_ID = re.compile(r"sha256:[0-9a-f]{64}")


def check_scene(find: Find, scene: Scene) -> None:
    """Raises InvalidRequest that tells of each file of a scene that was not uploaded, or is not what it is used as."""
    faults = [found for path, part in parts_with_files(scene, "scene") if (found := _fault(find, path, part))]
    if faults:
        raise InvalidRequest("The scene names files that cannot be rendered.", *faults)


def parts_with_files(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Every part of a scene that names a file, with its path as the scene is written."""
    if isinstance(value, tuple):
        for position, item in enumerate(value):
            yield from parts_with_files(item, f"{path}[{position}]")
    elif isinstance(value, BaseModel):
        if getattr(value, "file", None):
            yield path, value
        for name, item in value:
            yield from parts_with_files(item, f"{path}.{name}")


def _fault(find: Find, path: str, part: Any) -> Fault | None:
    match part:
        case ImageLight():
            needed = "picture"
        case MeshShape() | MeshSurface():
            needed = "mesh"
        case _:
            needed = "volume"
    row = find(part.file) if FILE_ID.fullmatch(part.file) else None
    if row is None:
        message = f"must be the id (sha256:…) of a {needed} that was uploaded to /api/v1/volumes"
    elif row["type"] != needed:
        message = f"must be a {needed}; {row['name']} is a {row['type']}"
    else:
        return _fault_within(path, part, row)
    return Fault(field=f"{path}.file", message=message)


def _fault_within(path: str, part: Any, row: RowMapping) -> Fault | None:
    """Of a file that is of the right type."""
    try:
        if row["type"] == "picture":
            check_size(row["width"], row["height"], row["name"])
        elif row["type"] == "volume":
            _check_grid(part, [GridInfo(**grid) for grid in row["grids"]])
    except ImageError as error:
        return Fault(field=f"{path}.file", message=str(error))
    except VolumeError as error:
        return Fault(field=f"{path}.grid", message=f"{row['name']} {error}")
    return None


def _check_grid(part: Any, grids: list[GridInfo]) -> None:
    """The grid that the renderer would read, by the same rules. Raises VolumeError, without the file's name."""
    name = part.grid or "temperature" if isinstance(part, BlackbodyEmission) else part.grid
    info = grids[choose([grid.name for grid in grids], name)]
    # Only of a density something must be there.
    if isinstance(part, GridVolume) or info.voxels:
        check_info(info)
