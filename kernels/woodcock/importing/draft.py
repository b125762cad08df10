"""The new scene while it is being put together, and the files that go beside it."""

from __future__ import annotations

import io
import json
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from woodcock.files import replacing
from woodcock.importing.geometry import Fields, Geometry, Mesh, ply
from woodcock.importing.report import Report, SourceError, shown
from woodcock.importing.transforms import Array
from woodcock.scene import MAX_LIGHTS, MAX_SURFACES, MAX_VOLUMES, UPLOADED, SceneError, parse

#: Where one medium ends at another, other renderers take the inner one; here all count.
GOES_ON = "the medium outside goes on inside this shape: where media overlap, they add"


def seen_through(material: Fields | None) -> bool:
    return material is None or "ior" in material


@dataclass
class Medium:
    """A medium to fill shapes with: a volume but for its shape; `box` are the corners (8, 3) of a grid."""

    fields: Fields
    box: Array | None = None
    placed: bool = False

    @property
    def grid(self) -> bool:
        return bool(self.fields["kind"] == "grid")


class Draft:
    """A scene file at `path` that is not written before `write`; `source` is the file that is imported."""

    def __init__(self, source: Path, path: Path, report: Report) -> None:
        self.source, self.path, self.report = source, path, report
        self.scene: Fields = {"camera": None, "volumes": [], "surfaces": [], "lights": []}
        self._files: dict[str, Callable[[Path], object]] = {}
        self._meshes: dict[bytes, str] = {}

    def volume(self, where: str, fields: Fields) -> None:
        self._add("volumes", MAX_VOLUMES, where, fields)

    def surface(self, where: str, fields: Fields) -> None:
        self._add("surfaces", MAX_SURFACES, where, fields)

    def light(self, where: str, fields: Fields) -> None:
        self._add("lights", MAX_LIGHTS, where, fields)

    def _add(self, what: str, most: int, where: str, fields: Fields) -> None:
        if len(self.scene[what]) < most:
            self.scene[what].append(fields)
        else:
            self.report.note(where, f"left out: a scene holds {most} {what} at most")

    def fill(self, where: str, geometry: Geometry, medium: Medium) -> None:
        """The medium inside a shape."""
        if not medium.grid:
            if (shape := geometry.bounds(self)) is None:
                self.report.note(where, "the medium inside is left out: the shape is not closed")
            else:
                self.volume(where, {"kind": "constant", "shape": shape, **medium.fields})
            return
        inside = geometry.contains(medium.box) if medium.box is not None else None
        if inside is False:
            self.report.note(where, "the shape does not hold all of the grid of its medium: it is carried over uncut")
        elif inside is None:
            self.report.note(where, "not checked that the shape holds all of the grid of its medium, which is not cut")
        if not medium.placed:
            medium.placed = True
            self.volume(where, medium.fields)

    def shape(
        self, where: str, geometry: Geometry, material: Fields | None, flipped: bool, medium: Medium | None
    ) -> None:
        """A surface of a material (None lets everything pass), whose normal is `flipped`, and the medium inside."""
        if medium is not None:
            self.fill(where, geometry, medium)
        if material is None:
            return
        fields, wrong = geometry.surface(self, flipped)
        if wrong and "ior" in material:  # inside and outside change places
            material = {**material, "ior": 1 / material["ior"]}
        elif wrong and material["kind"] == "emissive" and not material.get("two_sided"):
            self.report.note(where, "shines on the other side: the orientation of this shape cannot be reversed")
        self.surface(where, {**fields, "material": material})

    # Files

    def refer(self, name: str, folder: Path, where: str) -> str:
        """How the new scene names a file of the source's; says so where it is not there or lies elsewhere."""
        if not name or "\0" in name or name.endswith(("/", "\\")):
            raise SourceError(f"{where}: {shown(name)} is no name of a file")
        path = folder / name
        relative = os.path.relpath(path, self.path.parent).replace(os.sep, "/")
        if not os.path.isfile(path):  # noqa: PTH113 - no exception for what is no name
            self.report.note(where, f"the file {shown(name)} is not there; the scene refers to it all the same")
        if os.path.relpath(path, self.source.parent).startswith(".."):
            self.report.note(where, f"refers to a file outside the scene's folder: {shown(relative)}")
        return f"./{relative}" if relative.startswith(UPLOADED) else relative

    def mesh(self, mesh: Mesh) -> str:
        data = ply(mesh)
        if data not in self._meshes:
            self._meshes[data] = self._file(mesh.name, ".ply", lambda path: path.write_bytes(data))
        return self._meshes[data]

    def array(self, name: str, values: NDArray[Any]) -> str:
        """A grid, indexed [z][y][x] or [z][y][x][3]."""

        def write(path: Path) -> None:
            buffer = io.BytesIO()
            np.save(buffer, np.ascontiguousarray(values), allow_pickle=False)
            path.write_bytes(buffer.getvalue())

        return self._file(name, ".npy", write)

    def picture(self, name: str, write: Callable[[Path], object]) -> str:
        return self._file(name, ".exr", write)

    def _file(self, name: str, suffix: str, write: Callable[[Path], object]) -> str:
        """A file beside the scene, of a name of its own."""
        clean = re.sub(r"[^\w-]+", "-", name, flags=re.ASCII).strip("-")[:40] or "unnamed"
        stem, number = f"{self.path.stem}.{clean}", 2
        file = f"{stem}{suffix}"
        while file in self._files:
            file, number = f"{stem}-{number}{suffix}", number + 1
        self._files[file] = write
        return file

    def write(self) -> list[Path]:
        """Writes the scene and its files, once it is sure that the scene is one. Raises SourceError."""
        scene = {key: value for key, value in _tidy(self.scene).items() if value not in (None, [])}
        if "volumes" not in scene and "surfaces" not in scene:
            raise SourceError(f"{self.source}: holds no medium and no surface that can be carried over")
        text = _pretty(scene) + "\n"
        try:
            parse(text)
        except SceneError as error:
            raise SourceError("\n".join(f"{self.source}: {line}" for line in str(error).splitlines())) from None
        paths = []
        for file, write in self._files.items():
            paths.append(self.path.parent / file)
            with replacing(paths[-1]) as temporary:
                write(temporary)
        with replacing(self.path) as temporary:
            temporary.write_text(text)
        return [self.path, *paths]


def _tidy(value: Any) -> Any:
    """Numbers without the dust of rounding: twelve digits, and nothing beside a sum that should be 0."""
    if isinstance(value, dict):
        return {key: _tidy(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        if value and all(isinstance(item, float) for item in value):
            largest = max(map(abs, value))
            return [0.0 if abs(item) < 1e-14 * largest else _tidy(item) for item in value]
        return [_tidy(item) for item in value]
    return float(f"{value:.12g}") + 0.0 if isinstance(value, float) else value


def _pretty(value: Any, indent: str = "") -> str:
    """JSON with lists of numbers on one line."""
    inner = indent + "  "
    if isinstance(value, dict) and value:
        items = [f"{json.dumps(key, ensure_ascii=False)}: {_pretty(item, inner)}" for key, item in value.items()]
        return "{\n" + ",\n".join(inner + item for item in items) + f"\n{indent}}}"
    if isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        return "[\n" + ",\n".join(inner + _pretty(item, inner) for item in value) + f"\n{indent}]"
    return json.dumps(value, ensure_ascii=False)
