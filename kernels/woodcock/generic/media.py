"""Any media: the numbers that lean programs have for each (volume/text.py), in arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from woodcock.generic.fields import PLACE, STORAGES, Fields
from woodcock.generic.slots import array, kinds, nothing, single
from woodcock.integrator.volumetric_path_full import shapes
from woodcock.layout import Record, module
from woodcock.majorant import grid as majorant_grid
from woodcock.scene import MAX_VOLUMES, BlackbodyEmission, ConstantVolume, Emission, GridMajorant, Majorant, Shape
from woodcock.space import Space
from woodcock.volume.compose import TRACKING, compose
from woodcock.volume.field import FIELDS, Buffer
from woodcock.volume.media import Medium

SHAPES, EMISSIONS = kinds(Shape), ("none", *kinds(Emission))
#: emission: position in EMISSIONS; thermal: is what it emits times σ_a; table: where its black body's begins.
MEDIUM = {
    "grid": "int",
    "shape": "int",
    "emission": "int",
    "thermal": "int",
    "table": "int",
    "to_local": "affine",
    "size": "vector3",
    "sigma_t": "colour",
    "albedo": "colour",
}
#: How many media; does any scatter, emit?
HELD = {"media": "int", "scattering": "int", "emitting": "int"}
#: Of a medium, in the order in which they are numbered.
PARTS = ("density", "albedo", "emission")
#: Without grids nothing is tracked: every ray lies beyond a box of no size.
NO_TRACKING = {"to_local": np.array([[0.0, 0, 0, -1]] * 3), "size": np.zeros(3)}
NO_MAJORANT = {**nothing(majorant_grid.FIELDS), "cells_x": 1, "cells_y": 1, "cells_z": 1}


@dataclass(frozen=True)
class Media:
    """kinds: of what is in use; files: for before `struct world`; text: of the lookups, for after it."""

    records: list[Record]
    buffers: dict[str, Buffer]
    files: list[str]
    text: str
    facts: dict[str, Any]


def media(held: Sequence[Medium], space: Space, majorant: Majorant, *, scattering: bool) -> Media:
    """A global majorant is a grid of one cell. Raises SceneError."""
    under = majorant if isinstance(majorant, GridMajorant) else GridMajorant(resolution=1)
    lean = compose(held, space, under)
    numbers = {record.member: record for record in lean.records}
    fields, tables, offset = Fields(), list[Buffer](), 0
    rows: list[dict[str, Any]] = []
    own: list[dict[str, Any] | None] = []
    places: list[dict[str, Any] | None] = []
    for i, medium in enumerate(held):
        name, volume = f"medium_{i}", medium.volume
        emitted = numbers.get(f"{name}_emission_numbers")
        rows.append(
            {
                **nothing(MEDIUM),
                **numbers[name].values,
                "grid": int(medium.density is not None),
                "shape": SHAPES.index(volume.shape.kind) if isinstance(volume, ConstantVolume) else 0,
                "emission": EMISSIONS.index(emitted.kind) if emitted else 0,
                "thermal": int(isinstance(volume.emission, BlackbodyEmission)),
                "table": offset,
            }
        )
        for part in PARTS:
            field = getattr(medium, part)
            own.append(dict(numbers[f"{name}_{medium.place(part)}_field"].values) if field else None)
            places.append(fields.add(field) if field else None)
        if table := lean.buffers.get(f"{name}_emission_table"):
            tables.append(table)
            offset += table.size
    counts = {"media": len(held), "scattering": int(scattering), "emitting": int(any(row["emission"] for row in rows))}
    tracking, bounds = (numbers.get(name) for name in ("tracking", "majorant"))
    records = [
        Record("held", "", "held", HELD, counts),
        single("tracking", "", "tracking", TRACKING, tracking.values if tracking else NO_TRACKING),
        single("majorant", "grid", "majorant", majorant_grid.FIELDS, bounds.values if bounds else NO_MAJORANT),
        array("medium", "", "media", MEDIUM, rows, MAX_VOLUMES),
        array("volume", "field", "fields", FIELDS, own, len(PARTS) * MAX_VOLUMES),
        array("stored", "field", "stored", PLACE, places, len(PARTS) * MAX_VOLUMES),
        *(_by_medium(numbers, "emission", kind, "medium_{}_emission_numbers") for kind in EMISSIONS[1:]),
        *_shapes(held, space),
    ]
    buffers = {
        "majorant_grid_bounds": lean.buffers.get("majorant_grid_bounds", Buffer.of(np.zeros(1, np.float32))),
        "emission_tables": Buffer.of(
            np.concatenate([np.zeros(6, np.float32), *(t.array() for t in tables)])[6 * bool(tables) :]
        ),
        **fields.buffers(),
    }
    files = [
        "volume/field.h",
        *(f"volume/field_{storage}.h" for storage in STORAGES),
        "majorant/grid_cells.h",
        "majorant/grid.h",
        *(f"emission/{kind}.h" for kind in EMISSIONS[1:]),
    ]
    return Media(records, buffers, files, _numbered() + fields.text(), lean.facts)


def _by_medium(numbers: dict[str, Record], concept: str, kind: str, member: str) -> Record:
    found = (numbers.get(member.format(i)) for i in range(MAX_VOLUMES))
    rows = [record.values if record and record.kind == kind else None for record in found]
    return array(concept, kind, f"{concept}_{kind}", module(concept, kind).FIELDS, rows, MAX_VOLUMES)


def _shapes(held: Sequence[Medium], space: Space) -> list[Record]:
    found = {record.member: record for record in shapes([medium.volume for medium in held], space)}
    return [_by_medium(found, "shape", kind, "shape_{}") for kind in SHAPES]


def _numbered() -> str:
    names = [f"EMISSION_{kind.upper()} = {i}" for i, kind in enumerate(EMISSIONS)]
    names += [f"SHAPE_{kind.upper()} = {i}" for i, kind in enumerate(SHAPES)]
    return f"enum {{ MOST_MEDIA = {MAX_VOLUMES}, {', '.join(names)} }};\n"
