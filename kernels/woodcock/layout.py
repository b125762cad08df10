"""Scene -> the kinds it uses, one constant record, the C structs that match it, the buffers it needs, and the parts of
the program made for it. Each integrator lays its scenes out itself: `integrator/<name>.py` beside `<name>.cl`.

Kinds compile, numbers upload: two scenes that differ in numbers only have the same structs. Every member of a struct is
four bytes wide, so that C and numpy agree on offsets without padding; a test asks each device.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from woodcock.scene import BlackbodyEmission
from woodcock.space import Space

if TYPE_CHECKING:
    from woodcock.formats import Grid
    from woodcock.volume.field import Buffer

#: Members of a C type, all of four bytes; a colour has as many as the scene has channels.
WIDTHS = {"float": 1, "int": 1, "uint": 1, "vector3": 3, "affine": 12}
#: C types of a record's members in a program of doubles.
WIDE = {"float": "double", "int": "long", "uint": "ulong"}
#: C types of buffers' elements.
ELEMENTS = {"f4": "float", "i4": "int", "u4": "uint", "u2": "ushort", "u1": "uchar"}

#: Reads a grid: file, and name or None.
Read = Callable[[str, str | None], "Grid"]
Kinds = dict[str, tuple[str, ...]]
Buffers = Mapping[str, "NDArray[np.generic] | Buffer"]


def module(concept: str, kind: str) -> ModuleType:
    """The Python side of a kind: `woodcock.<concept>.<kind>`."""
    return importlib.import_module(f"woodcock.{concept}.{kind}")


@dataclass(frozen=True)
class Record:
    """One struct in the scene's record: `struct <concept>_<kind> <member>`; others: of an array, the values of the
    elements that follow the first."""

    concept: str
    kind: str
    member: str
    fields: Mapping[str, str]
    values: Mapping[str, Any]
    others: tuple[Mapping[str, Any], ...] = ()

    @property
    def elements(self) -> tuple[Mapping[str, Any], ...]:
        return (self.values, *self.others)

    @property
    def struct(self) -> str:
        return f"{self.concept}_{self.kind}" if self.kind else self.concept


@dataclass(frozen=True)
class Layout:
    """What a scene needs on the device.

    kinds: by concept; names: of the film's channels; parts: what `flatten` joins after lanes, vectors, spectra and
    structs, with `struct world` and the entry coming from `program.py`; facts: what the report says beside;
    listed: can it be launched over a list of pixels?
    """

    integrator: str
    kinds: Kinds
    channels: int
    names: tuple[str, ...]
    records: tuple[Record, ...]
    buffers: Buffers
    space: Space
    before_world: tuple[str, ...]
    after_world: tuple[str, ...]
    facts: dict[str, Any] = field(default_factory=dict)
    listed: bool = False

    @property
    def deterministic(self) -> bool:
        """Is it solved without random numbers?"""
        return not self.integrator.startswith("volumetric_path")

    def through(self, width: int, height: int) -> Layout:
        """The same view through so many pixels; its program is the same."""
        (film,) = (record for record in self.records if record.member == "film")
        looked = replace(film, values={**film.values, "width": width, "height": height})
        return replace(self, records=tuple(looked if record is film else record for record in self.records))

    def structs(self, *, precise: bool = False) -> str:
        """The C text of every struct and of `struct scene`, which holds one member a record; precise: 8 bytes a member,
        for programs of doubles."""
        lines: list[str] = []
        for record in {record.struct: record for record in self.records}.values():
            members = " ".join(f"{ctype} {name};" for name, ctype in record.fields.items())
            lines.append(f"struct {record.struct} {{ {members} }};")
        counts = [f"[{len(record.elements)}]" if record.others else "" for record in self.records]
        members = " ".join(
            f"struct {record.struct} {record.member}{count};"
            for record, count in zip(self.records, counts, strict=True)
        )
        text = "\n".join([*lines, f"struct scene {{ {members} }};"]) + "\n"
        # vector3, affine and colour follow `number`.
        return re.sub(r"\b(float|int|uint)\b", lambda name: WIDE[name[0]], text) if precise else text

    def pack(self, *, precise: bool = False) -> NDArray[np.uint8]:
        """The numbers' bytes, as `struct scene` lays them out; unrounded if precise."""
        parts: list[NDArray[np.uint8]] = []
        for record in self.records:
            for values in record.elements:
                for name, ctype in record.fields.items():
                    parts.append(_bytes(values[name], ctype, self.channels, 8 if precise else 4))
        return np.concatenate(parts)

    def offsets(self) -> list[int]:
        """Byte offset of every member of `struct scene`, and last its size."""
        sizes = [
            sum(4 * (self.channels if ctype == "colour" else WIDTHS[ctype]) for ctype in record.fields.values())
            * len(record.elements)
            for record in self.records
        ]
        return [0, *np.cumsum(sizes).tolist()]


def _bytes(value: Any, ctype: str, channels: int, width: int) -> NDArray[np.uint8]:
    if ctype in ("int", "uint"):
        return np.array([value], f"{ctype[0]}{width}").view(np.uint8)
    flat = np.asarray(value, np.float64).reshape(-1)
    if ctype == "colour":
        flat = np.broadcast_to(flat, channels)
    assert flat.size == (channels if ctype == "colour" else WIDTHS[ctype])
    return flat.astype(f"f{width}").view(np.uint8)


def instances(
    concept: str, members: Iterable[tuple[str, Any]], *given: Space
) -> tuple[list[Record], dict[str, NDArray[np.generic]]]:
    """Records of models, each under its member's name, and their kinds' buffers, shared by a kind's instances.

    given: what the kinds' `record` takes after the model.
    """
    records: list[Record] = []
    chunks: dict[str, list[NDArray[np.generic]]] = {}
    for member, model in members:
        kind = module(concept, model.kind)
        if not hasattr(kind, "BUFFERS"):
            values = kind.record(model, *given)
        else:
            offsets = {}
            for name, array in kind.buffers(model).items():
                held = chunks.setdefault(f"{concept}_{model.kind}_{name}", [])
                offsets[name] = sum(chunk.size for chunk in held)
                held.append(array)
            values = kind.record(model, *given, offsets)
        records.append(Record(concept, model.kind, member, kind.FIELDS, values))
    return records, {name: np.concatenate(arrays) for name, arrays in chunks.items()}


def element(array: NDArray[np.generic] | Buffer) -> str:
    """The C type of a buffer's elements."""
    return ELEMENTS[array.dtype.str[1:]]


SPECTRA = ("albedo", "sigma_t", "scale", "epsilon", "radiance", "irradiance", "intensity", "reflectance", "luminance")


def coloured(model: BaseModel) -> bool:
    """Does any spectrum of the model, or of the models in it, have three channels by what the scene itself says?"""
    for name, value in model:
        parts = value if isinstance(value, tuple) and name not in SPECTRA else (value,)
        if name in SPECTRA and isinstance(value, tuple):
            return True
        if any(isinstance(part, BaseModel) and coloured(part) for part in parts):
            return True
    return isinstance(model, BlackbodyEmission)
