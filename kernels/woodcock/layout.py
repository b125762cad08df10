"""Scene -> the kinds it uses, one constant record, the C structs that match it, and the buffers it needs.

Kinds compile, numbers upload: two scenes that differ in numbers only have the same structs. Every member of a struct is
four bytes wide, so that C and numpy agree on offsets without padding; a test asks each device.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from woodcock.scene import ConstantVolume, GridVolume, Scene, Volume
from woodcock.space import Array, Space

if TYPE_CHECKING:
    from woodcock.formats import Grid

#: Members of a C type, all of four bytes; a colour has as many as the scene has channels.
WIDTHS = {"float": 1, "int": 1, "uint": 1, "vector3": 3, "affine": 12}


def module(concept: str, kind: str) -> ModuleType:
    """The Python side of a kind: `woodcock.<concept>.<kind>`."""
    return importlib.import_module(f"woodcock.{concept}.{kind}")


@dataclass(frozen=True)
class Record:
    """One struct in the scene's record: `struct <concept>_<kind> <member>`."""

    concept: str
    kind: str
    member: str
    fields: Mapping[str, str]
    values: Mapping[str, Any]

    @property
    def struct(self) -> str:
        return f"{self.concept}_{self.kind}" if self.kind else self.concept


@dataclass(frozen=True)
class Layout:
    """What a scene needs on the device: kinds by concept, structs, numbers and buffers."""

    kinds: dict[str, tuple[str, ...]]
    channels: int
    records: tuple[Record, ...]
    buffers: dict[str, NDArray[np.generic]]
    space: Space

    def structs(self) -> str:
        """The C text of every struct and of `struct scene`, which holds one member a record."""
        lines: list[str] = []
        for record in {record.struct: record for record in self.records}.values():
            members = " ".join(f"{ctype} {name};" for name, ctype in record.fields.items())
            lines.append(f"struct {record.struct} {{ {members} }};")
        members = " ".join(f"struct {record.struct} {record.member};" for record in self.records)
        return "\n".join([*lines, f"struct scene {{ {members} }};"]) + "\n"

    def pack(self) -> NDArray[np.uint32]:
        """The numbers, as `struct scene` lays them out."""
        words: list[NDArray[np.uint32]] = []
        for record in self.records:
            for name, ctype in record.fields.items():
                words.append(_words(record.values[name], ctype, self.channels))
        return np.concatenate(words)

    def offsets(self) -> list[int]:
        """Byte offset of every member of `struct scene`, and last its size."""
        sizes = [
            sum(4 * (self.channels if ctype == "colour" else WIDTHS[ctype]) for ctype in record.fields.values())
            for record in self.records
        ]
        return [0, *np.cumsum(sizes).tolist()]


def _words(value: Any, ctype: str, channels: int) -> NDArray[np.uint32]:
    if ctype in ("int", "uint"):
        return np.array([value], np.dtype(ctype + "32").newbyteorder("=")).view(np.uint32)
    flat = np.asarray(value, np.float64).reshape(-1)
    if ctype == "colour":
        flat = np.broadcast_to(flat, channels)
    assert flat.size == (channels if ctype == "colour" else WIDTHS[ctype])
    return flat.astype(np.float32).view(np.uint32)


class _Medium(NamedTuple):
    """A volume, read: size, its extent in local space; bound, on σ_t; record, its numbers in a space."""

    kinds: dict[str, tuple[str, ...]]
    to_scene: Array
    size: tuple[int, ...]
    bound: float
    record: Callable[[Space], dict[str, Any]]
    buffers: dict[str, NDArray[np.generic]]

    def corners(self) -> Array:
        """(8, 3), in the scene."""
        corners = np.array(list(np.ndindex(2, 2, 2))) * np.array(self.size)
        return np.asarray(corners @ self.to_scene[:3, :3].T + self.to_scene[:3, 3])


def _medium(volume: Volume, read: Callable[[GridVolume], Grid]) -> _Medium:
    kind = module("volume", volume.kind)
    if isinstance(volume, ConstantVolume):
        kinds: dict[str, tuple[str, ...]] = {
            "volume": ("constant",),
            "free_flight": ("analytic",),
            "transmittance": ("exact",),
        }
        return _Medium(
            kinds, kind.to_scene(volume), (1, 1, 1), volume.sigma_t, lambda space: kind.record(volume, space), {}
        )
    grid = read(volume)
    largest, storage = kind.check(grid, volume.file), kind.storage(grid.values)
    return _Medium(
        {"storage": (storage,), "volume": ("grid",), "free_flight": ("delta",), "transmittance": ("ratio",)},
        kind.to_scene(volume, grid),
        grid.values.shape[::-1],
        volume.scale * largest,
        lambda space: kind.record(volume, grid, largest, space),
        {"density": kind.bricks(grid.values, storage)},
    )


def lay_out(scene: Scene, read: Callable[[GridVolume], Grid]) -> Layout:
    """Reads the volumes by `read` and lays the scene out. Raises VolumeError."""
    (volume,) = scene.volumes
    medium = _medium(volume, read)
    strongest = max((float(module("light", light.kind).strength(light).max()) for light in scene.lights), default=0.0)
    space = Space.around(medium.corners(), strongest)

    film = {"width": scene.film.width, "height": scene.film.height, "seed": scene.seed}
    records = [Record("film", "", "film", {"width": "int", "height": "int", "seed": "uint"}, film)]

    def add(concept: str, kind: str, member: str, values: dict[str, Any]) -> None:
        records.append(Record(concept, kind, member, module(concept, kind).FIELDS, values))

    camera, aspect = module("camera", scene.camera.kind), scene.film.width / scene.film.height
    add("camera", scene.camera.kind, "camera", camera.record(scene.camera, aspect, space))
    add("volume", volume.kind, "volume", medium.record(space))
    add("majorant", "global", "majorant", module("majorant", "global").record(medium.bound, space))
    add("phase", volume.phase.kind, "phase", module("phase", volume.phase.kind).record(volume.phase))
    for index, light in enumerate(scene.lights):
        add("light", light.kind, f"light_{index}", module("light", light.kind).record(light, space))

    kinds = {
        "integrator": ("volumetric_path",),
        "camera": (scene.camera.kind,),
        **medium.kinds,
        "majorant": ("global",),
        "phase": (volume.phase.kind,),
        "light": tuple(dict.fromkeys(light.kind for light in scene.lights)),
    }
    if all(module("light", kind).ON_ESCAPE for kind in kinds["light"]):
        del kinds["transmittance"]
    return Layout(kinds, channels(scene), tuple(records), medium.buffers, space)


def channels(scene: Scene) -> int:
    """1 where every spectrum of the scene is one number, else 3."""
    spectra = [volume.albedo for volume in scene.volumes]
    spectra += [light.radiance if light.kind == "constant" else light.irradiance for light in scene.lights]
    return 3 if any(isinstance(spectrum, tuple) for spectrum in spectra) else 1
