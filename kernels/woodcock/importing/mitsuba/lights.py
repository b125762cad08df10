"""Mitsuba's emitters that are no surface."""

from __future__ import annotations

import numpy as np

from woodcock.importing.draft import Draft
from woodcock.importing.geometry import placement
from woodcock.importing.mitsuba.element import Element
from woodcock.importing.report import shown
from woodcock.importing.transforms import Array, point, rotate, vector

#: Mitsuba's picture of all directions has +z in its middle, the scene's has -z.
HALF_TURN = rotate(np.array([0.0, 1.0, 0.0]), 180, "")


def light(element: Element, draft: Draft, world: Array) -> None:
    where = element.where
    element.passed_over("sampling_weight")
    to_world = world @ element.transform()
    match element.kind:
        case "constant":
            draft.light(where, {"kind": "constant", "radiance": element.spectrum("radiance", 1.0, emitted=True)})
        case "envmap":
            _envmap(element, draft, to_world)
        case "directional":
            direction = element.vector("direction")
            travels = vector(to_world, np.array([0.0, 0.0, 1.0])) if direction is None else vector(world, direction)
            irradiance = element.spectrum("irradiance", 1.0, emitted=True)
            draft.light(where, {"kind": "directional", "direction": travels.tolist(), "irradiance": irradiance})
        case "point":
            position = element.vector("position")
            at = to_world[:3, 3] if position is None else point(world, position)
            intensity = element.spectrum("intensity", 1.0, emitted=True)
            draft.light(where, {"kind": "point", "position": at.tolist(), "intensity": intensity})
        case "spot":
            _spot(element, draft, to_world)
        case _:
            draft.report.note(where, f"left out: the emitter {shown(element.kind)}")
            element.left_out()


def _envmap(element: Element, draft: Draft, to_world: Array) -> None:
    name, folder, where = element.file()
    scale = element.number("scale", 1.0)
    file = draft.refer(name, folder, where)
    if not name.lower().endswith((".exr", ".hdr", ".rgbe")):
        draft.report.note(where, "the environment must be an EXR or HDR picture: convert it")
    draft.light(element.where, {"kind": "image", "file": file, "scale": scale, **placement(to_world @ HALF_TURN)})


def _spot(element: Element, draft: Draft, to_world: Array) -> None:
    cutoff = element.number("cutoff_angle", 20.0)
    beam = element.number("beam_width", cutoff * 3 / 4)
    if "texture" in element:
        element.spectrum("texture", 1.0)
    draft.report.note(
        element.where, "between beam and cutoff this spot falls off smoothly in the cosine, not linearly in the angle"
    )
    position = to_world[:3, 3]
    fields = {
        "kind": "spot",
        "position": position.tolist(),
        "target": (position + vector(to_world, np.array([0.0, 0.0, 1.0]))).tolist(),
        "intensity": element.spectrum("intensity", 1.0, emitted=True),
        "cutoff": cutoff,
        "beam": min(beam, cutoff * (1 - 1e-6)),
    }
    draft.light(element.where, fields)
