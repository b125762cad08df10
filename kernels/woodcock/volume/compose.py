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
from woodcock.majorant.control import Control
from woodcock.scene import GridMajorant, Majorant
from woodcock.space import Array, Space
from woodcock.volume.field import CHUNK, Buffer
from woodcock.volume.glow import Box, dense_glow
from woodcock.volume.media import Medium, corners
from woodcock.volume.text import Composed, Writer

TRACKING = {"to_local": "affine", "size": "vector3"}


def compose(
    media: Sequence[Medium],
    space: Space,
    majorant: Majorant,
    *,
    control: bool = False,
    residual: bool = False,
    pairs: bool = False,
    glow: bool = False,
    most_bytes: int = CHUNK,
) -> Composed:
    """control: of every grid, its least in every cell of the majorant; residual: and a bound on what is above.

    pairs: σ_t of grids at two points of a cell; glow: whether emission is dense; most_bytes: of a buffer, what the
    device takes in one piece.
    """
    composed = Composed()
    grids = {index: medium for index, medium in enumerate(media) if medium.density}
    if grids:
        bounds, box = _tracking(composed, grids, space, majorant, control=control, residual=residual)
        composed.dense_glow = glow and dense_glow(media, bounds, box)
    grey = all(medium.grey for medium in media)
    for index, medium in enumerate(media):
        composed.use("volume", medium.volume.kind)
        writer = Writer(composed, f"medium_{index}", medium, space, grey, min(most_bytes, CHUNK))
        composed.text += writer.grid(alone=len(grids) == 1) if medium.density else writer.constant()
        if medium.density and control:
            composed.text += writer.minorant()
        if medium.density and pairs:
            composed.text += writer.pair()
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


def _tracking(
    composed: Composed,
    grids: Mapping[int, Medium],
    space: Space,
    majorant: Majorant,
    *,
    control: bool,
    residual: bool,
) -> tuple[Array, Box]:
    """The space in which all grids are tracked together, and the majorant over it: the voxels of the only one, else an
    axis-aligned box around all. grids: by their place among the media.

    Gives the majorant of every cell, [z][y][x] in scene units, and the box that is cut into these.
    """
    media = list(grids.values())
    placed = [(medium.density, medium.to_scene(medium.density)) for medium in media if medium.density]
    points = np.concatenate([corners(*pair) for pair in placed])
    low, high = points.min(axis=0), points.max(axis=0)
    if len(media) == 1:
        size, to_local = np.array(placed[0][0].size, float), space.affine(placed[0][1])
        box = Box(np.zeros(3), size, np.asarray(np.linalg.inv(placed[0][1])))
    else:
        size = np.ldexp(high - low, -space.length_exponent)
        to_local = np.hstack([np.eye(3), -space.point(low)[:, None]])
        box = Box(low, high, np.eye(4))
    composed.records.append(Record("tracking", "", "tracking", TRACKING, {"to_local": to_local, "size": size}))

    # The device's space is about one long.
    error = majorant_grid.MARGIN * float(np.ldexp(1.0, space.length_exponent))
    around = None if len(media) == 1 else (low, high)
    cells = majorant_grid.counts(size, majorant.resolution) if isinstance(majorant, GridMajorant) else (1, 1, 1)
    bounds = np.full((1, 1, 1), sum(float(medium.bound.max()) for medium in media))
    values: Mapping[str, Any]
    if isinstance(majorant, GridMajorant):
        bounded = [medium.bounded() for medium in media]
        if around is None:
            bounds = majorant_grid.bounds(bounded[0], cells, error)
        else:
            bounds = majorant_grid.combined(bounded, cells, *around, error)
        sides = bounded[0].sides if around is None else high - low
        # A control's cells are the majorant's.
        through, kept = majorant_grid.cut(bounds, sides, space, blocks=majorant.blocks and not control)
        composed.buffers["majorant_grid_bounds"] = Buffer.of(kept)
        composed.facts["majorant"] = {"cells": cells, "empty": float(np.mean(bounds == 0))}
        composed.use("majorant", "grid", through, "majorant/grid.h")
        fields, values = majorant_grid.FIELDS, majorant_grid.record(cells, size)
    else:
        kind = importlib.import_module("woodcock.majorant.global")
        composed.use("majorant", "global", "majorant/global_walk.h")
        fields, values = kind.FIELDS, kind.record(float(bounds.max()), space)
    composed.records.append(Record("majorant", majorant.kind, "majorant", fields, values))

    if control:
        found = Control.of([medium.stored() for medium in media], cells, around, error, bounds)
        for index, least in zip(grids, found.least, strict=True):
            composed.buffers.update(
                {f"minorant_{index}_{c}": Buffer.of(values.reshape(-1)) for c, values in enumerate(least)}
            )
        if residual:
            above = majorant_grid.buffers(found.residual, space)["bounds"]
            composed.buffers["majorant_residual"] = Buffer.of(above)
        composed.text += _cell(majorant)
    return bounds, box


def _cell(majorant: Majorant) -> str:
    """What an array of the majorant's cells has for the one that a walk is in."""
    value = "gather(float, values, (integer)0)"
    if isinstance(majorant, GridMajorant):
        value = "majorant_grid_bound(&world->scene->majorant, values, walk->cell)"
    return f"""\
static inline real majorant_cell(const struct world *world, const majorant_walk *walk, __global const float *values) {{
    return {value};
}}
"""
