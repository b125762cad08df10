"""Any surfaces: primitives and materials of every kind under one hierarchy, which may be empty."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from woodcock.layout import module
from woodcock.space import Space
from woodcock.surface.build import KINDS, Body, build
from woodcock.surface.compose import MATERIALS, by_hierarchy, compose, parts_of


def surfaces(bodies: Sequence[Body], space: Space) -> tuple[dict[str, NDArray[np.generic]], bool]:
    """Every buffer that `parts` reads, and whether anything shines. Raises MeshError."""
    found: dict[str, NDArray[np.generic]] = {}
    emits = False
    if bodies:
        composed = compose(build(bodies, space), space, 3, hierarchy=True)
        found, emits = {name: array for name, (_, array) in composed.buffers.items()}, composed.emits
    corners = found.get("surface_mesh", np.zeros(module("surface", "mesh").WIDTH, np.float32))
    primitives = found.get("surface_primitives", np.zeros(3, np.int32))
    empty: dict[str, NDArray[np.generic]] = {
        "surface_boxes": np.zeros(6, np.float32),
        "surface_links": np.zeros(2, np.int32),  # the first: no boxes
        "surface_primitives": primitives,
        "surface_records": np.zeros(3, np.int32),
        "material_numbers": np.zeros(1, np.float32),
        **{f"surface_{kind}": np.zeros(module("surface", kind).WIDTH, np.float32) for kind in KINDS},
        "surface_mesh_normals": np.zeros_like(corners),
        "surface_emitter_ends": np.zeros(2, np.int32),
        "surface_emitters": np.zeros(1, np.int32),
        "surface_emitter_pdf": np.zeros(primitives.size // 3, np.float32),
    }
    return {name: found.get(name, array) for name, array in empty.items()}, emits


def parts() -> list[str]:
    """For `flatten`."""
    return parts_of(KINDS, MATERIALS, by_hierarchy(KINDS), smooth=True, emits=True)
