"""Scene -> the kinds it uses, one constant record, the C structs that match it, and the buffers it needs.

Kinds compile, numbers upload: two scenes that differ in numbers only have the same structs. Every member of a struct is
four bytes wide, so that C and numpy agree on offsets without padding; a test asks each device.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from woodcock.scene import GridVolume, Scene, Volume
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


def lay_out(scene: Scene, read: Callable[[GridVolume], Grid]) -> Layout:
    """Reads the volumes by `read` and lays the scene out. Raises VolumeError."""
    (volume,) = scene.volumes
    grid = read(volume) if isinstance(volume, GridVolume) else None
    lights = [(light, module("light", light.kind)) for light in scene.lights]
    strongest = max((float(m.strength(light).max()) for light, m in lights), default=0.0)
    space = Space.around(_corners(volume, grid), strongest)

    kinds: dict[str, tuple[str, ...]] = {"integrator": ("volumetric_path",), "camera": (scene.camera.kind,)}
    buffers: dict[str, NDArray[np.generic]] = {}
    film = {"width": scene.film.width, "height": scene.film.height, "seed": scene.seed}
    records = [Record("film", "", "film", {"width": "int", "height": "int", "seed": "uint"}, film)]

    def add(concept: str, kind: str, member: str, *arguments: Any) -> None:
        kind_module = module(concept, kind)
        records.append(Record(concept, kind, member, kind_module.FIELDS, kind_module.record(*arguments)))

    add("camera", scene.camera.kind, "camera", scene.camera, scene.film.width / scene.film.height, space)
    if isinstance(volume, GridVolume) and grid is not None:
        grids = module("volume", "grid")
        largest = grids.check(grid, volume.file)
        bound = volume.scale * largest
        storage = grids.storage(grid.values)
        buffers["density"] = grids.bricks(grid.values, storage)
        kinds |= {"storage": (storage,), "volume": ("grid",), "free_flight": ("delta",), "transmittance": ("ratio",)}
        add("volume", "grid", "volume", volume, grid, largest, space)
    else:
        assert not isinstance(volume, GridVolume)
        bound = volume.sigma_t
        kinds |= {"volume": ("constant",), "free_flight": ("analytic",), "transmittance": ("exact",)}
        add("volume", "constant", "volume", volume, space)
    kinds["majorant"] = ("global",)
    add("majorant", "global", "majorant", bound, space)
    kinds["phase"] = (volume.phase.kind,)
    add("phase", volume.phase.kind, "phase", volume.phase)
    for index, (light, light_module) in enumerate(lights):
        records.append(
            Record("light", light.kind, f"light_{index}", light_module.FIELDS, light_module.record(light, space))
        )
    kinds["light"] = tuple(dict.fromkeys(light.kind for light in scene.lights))
    if all(light_module.ON_ESCAPE for _, light_module in lights):
        del kinds["transmittance"]
    return Layout(kinds, channels(scene), tuple(records), buffers, space)


def channels(scene: Scene) -> int:
    """1 where every spectrum of the scene is one number, else 3."""
    spectra = [volume.albedo for volume in scene.volumes]
    spectra += [light.radiance if light.kind == "constant" else light.irradiance for light in scene.lights]
    return 3 if any(isinstance(spectrum, tuple) for spectrum in spectra) else 1


def _corners(volume: Volume, grid: Grid | None) -> Array:
    """(8, 3): the corners of the volume in the scene."""
    kind = module("volume", volume.kind)
    if grid is None:
        to_scene, size = kind.to_scene(volume), (1, 1, 1)
    else:
        to_scene, size = kind.to_scene(volume, grid), grid.values.shape[::-1]
    corners = np.array(list(np.ndindex(2, 2, 2))) * np.array(size)
    return np.asarray(corners @ to_scene[:3, :3].T + to_scene[:3, 3])
