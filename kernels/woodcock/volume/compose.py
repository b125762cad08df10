"""Media -> what of the device's program is made for them: records, buffers, and the functions by which loops ask medium
i for σ_t, albedo and ε. What a scene does not have is not in the text.

A product of two fields, σ_t × albedo say, is right in the mean only if their one-tap lookups take different random
words.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from woodcock.layout import Record
from woodcock.majorant import grid as majorant_grid
from woodcock.scene import GridMajorant, Majorant
from woodcock.space import Space
from woodcock.volume.field import CHUNK, Buffer
from woodcock.volume.media import Medium, corners
from woodcock.volume.text import Composed, Writer

TRACKING = {"to_local": "affine", "size": "vector3"}


def compose(media: Sequence[Medium], space: Space, majorant: Majorant, *, most_bytes: int = CHUNK) -> Composed:
    """most_bytes: of a buffer, what the device takes in one piece."""
    composed = Composed()
    grids = [medium for medium in media if medium.density]
    if grids:
        _tracking(composed, grids, space, majorant)
    grey = all(medium.grey for medium in media)
    for index, medium in enumerate(media):
        composed.use("volume", medium.volume.kind)
        writer = Writer(composed, f"medium_{index}", medium, space, grey, min(most_bytes, CHUNK))
        composed.text += writer.grid(alone=len(grids) == 1) if medium.density else writer.constant()
    composed.facts["media"] = [_facts(medium) for medium in media]
    return composed


def _facts(medium: Medium) -> dict[str, Any]:
    fields = {"density": medium.density, "albedo": medium.albedo, "emission": medium.emission}
    return {
        "kind": medium.volume.kind,
        "sigma_t": medium.bound.tolist(),
        "storage": {name: {"kind": f.storage, "error": f.error} for name, f in fields.items() if f},
        "emits": medium.emits,
        "scatters": medium.scatters,
        "coloured": medium.coloured,
    }


def _tracking(composed: Composed, grids: Sequence[Medium], space: Space, majorant: Majorant) -> None:
    """The space in which all grids are tracked together, and the majorant over it: the voxels of the only one, else an
    axis-aligned box around all."""
    placed = [(medium.density, medium.to_scene(medium.density)) for medium in grids if medium.density]
    points = np.concatenate([corners(*pair) for pair in placed])
    low, high = points.min(axis=0), points.max(axis=0)
    if len(grids) == 1:
        size, to_local = np.array(placed[0][0].size, float), space.affine(placed[0][1])
    else:
        size = np.ldexp(high - low, -space.length_exponent)
        to_local = np.hstack([np.eye(3), -space.point(low)[:, None]])
    box = {"to_local": to_local, "size": size}
    composed.records.append(Record("tracking", "", "tracking", TRACKING, box))

    values: Mapping[str, Any]
    if isinstance(majorant, GridMajorant):
        cells, bounded = majorant_grid.counts(size, majorant.resolution), [medium.bounded() for medium in grids]
        # The device's space is about one long.
        error = majorant_grid.MARGIN * float(np.ldexp(1.0, space.length_exponent))
        if len(grids) == 1:
            bounds = majorant_grid.bounds(bounded[0], cells, error)
        else:
            bounds = majorant_grid.combined(bounded, cells, low, high, error)
        composed.buffers["majorant_grid_bounds"] = Buffer.of(majorant_grid.buffers(bounds, space)["bounds"])
        composed.facts["majorant"] = {"cells": cells, "empty": float(np.mean(bounds == 0))}
        composed.use("majorant", "grid", "majorant/grid.h")
        fields, values = majorant_grid.FIELDS, majorant_grid.record(cells, size)
    else:
        kind = importlib.import_module("woodcock.majorant.global")
        composed.use("majorant", "global", "majorant/global_walk.h")
        fields, values = kind.FIELDS, kind.record(float(sum(medium.bound.max() for medium in grids)), space)
    composed.records.append(Record("majorant", majorant.kind, "majorant", fields, values))
