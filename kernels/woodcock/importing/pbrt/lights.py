"""pbrt's lights that are no surface."""

from __future__ import annotations

import math

from woodcock.importing import colour
from woodcock.importing.draft import Draft
from woodcock.importing.environment import from_equal_area
from woodcock.importing.geometry import Fields
from woodcock.importing.pbrt.world import Directive
from woodcock.importing.report import shown
from woodcock.importing.transforms import Array, inverse, point


def light(directive: Directive, draft: Draft, world: Array) -> None:
    parameters, where = directive.parameters, directive.where
    to_world = world @ directive.to_world
    scale = parameters.number("scale", 1.0)
    match directive.kind:
        case "infinite":
            if "filename" in parameters:
                _picture(directive, draft, to_world, scale)
                return
            lux = parameters.number("illuminance", -1.0)
            radiance = colour.triple(parameters.light("L", 1.0)) * scale * (lux / math.pi if lux > 0 else 1.0)
            draft.light(where, {"kind": "constant", "radiance": colour.simple(radiance)})
        case "distant":
            start, end = _ends(directive, to_world)
            lux = parameters.number("illuminance", -1.0)
            irradiance = colour.triple(parameters.light("L", 1.0)) * scale * (lux if lux > 0 else 1.0)
            fields: Fields = {"kind": "directional", "direction": (end - start).tolist()}
            draft.light(where, {**fields, "irradiance": colour.simple(irradiance)})
        case "point":
            position = point(to_world, parameters.point("from", (0.0, 0.0, 0.0)))
            power = parameters.number("power", -1.0)
            intensity = colour.triple(parameters.light("I", 1.0)) * scale * (power / (4 * math.pi) if power > 0 else 1)
            draft.light(where, {"kind": "point", "position": position.tolist(), "intensity": colour.simple(intensity)})
        case "spot":
            _spot(directive, draft, to_world, scale)
        case _:
            parameters.passed_over(*parameters.found)
            draft.report.note(where, f"left out: the light {shown(directive.kind)}")


def _ends(directive: Directive, to_world: Array) -> tuple[Array, Array]:
    parameters = directive.parameters
    start, end = parameters.point("from", (0.0, 0.0, 0.0)), parameters.point("to", (0.0, 0.0, 1.0))
    return point(to_world, start), point(to_world, end)


def _spot(directive: Directive, draft: Draft, to_world: Array, scale: float) -> None:
    parameters = directive.parameters
    start, end = _ends(directive, to_world)
    cutoff, edge = parameters.number("coneangle", 30.0), parameters.number("conedeltaangle", 5.0)
    beam = min(max(cutoff - edge, 0.0), cutoff * (1 - 1e-6))
    power = parameters.number("power", -1.0)
    if power > 0:
        inner, outer = math.cos(math.radians(beam)), math.cos(math.radians(cutoff))
        scale *= power / (2 * math.pi * ((1 - inner) + (inner - outer) / 2))
    fields = {
        "kind": "spot",
        "position": start.tolist(),
        "target": end.tolist(),
        "intensity": colour.simple(colour.triple(parameters.light("I", 1.0)) * scale),
        "cutoff": cutoff,
        "beam": beam,
    }
    draft.light(directive.where, fields)


def _picture(directive: Directive, draft: Draft, to_world: Array, scale: float) -> None:
    """pbrt's square picture becomes one of longitude and latitude, in the world's own directions."""
    parameters = directive.parameters
    name, where = parameters.string("filename", ""), parameters.at("filename")
    parameters.passed_over("portal")
    if "illuminance" in parameters:
        parameters.passed_over("illuminance")
        draft.report.note(parameters.at("illuminance"), "illuminance is not carried over: scale alone counts")
    draft.refer(name, parameters.folder, where)
    path = parameters.folder / name
    if not path.is_file():
        draft.report.note(where, "left out: an environment without its picture")
        return
    write = from_equal_area(path, where, inverse(to_world, directive.where))
    draft.report.note(where, "the square picture is resampled to one of longitude and latitude")
    file = draft.picture(path.stem, write)
    draft.light(directive.where, {"kind": "image", "file": file, "scale": scale})
