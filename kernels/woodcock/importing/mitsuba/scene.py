"""A Mitsuba 3 scene: camera, film, and who converts the rest."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from woodcock.importing.draft import Draft
from woodcock.importing.geometry import Fields
from woodcock.importing.mitsuba.element import Element
from woodcock.importing.mitsuba.lights import light
from woodcock.importing.mitsuba.shapes import Shapes
from woodcock.importing.mitsuba.xml import Document
from woodcock.importing.report import SourceError, number, shown
from woodcock.importing.transforms import MIRROR, Array, Pose, uniform_scale

LAYERS = {"depth": "depth", "position": "position", "sh_normal": "normal", "geo_normal": "normal", "albedo": "albedo"}


def convert(path: Path, draft: Draft) -> None:
    """Reads a scene into `draft`. Raises SourceError."""
    document = Document(path)
    version = document.root.attributes.get("version", "3.0.0")
    if not re.fullmatch(r"[23](\.\d+)*", version):
        draft.report.note(
            document.root.where, f"written for Mitsuba {shown(version)}: names from before 2.0 are unknown"
        )
    seen: dict[int, Element] = {}
    scene = Element(document.root, document, draft.report, seen)
    sensors = [sensor for _, sensor in scene.objects("sensor")]
    if not sensors:
        raise SourceError(f"{path}: has no <sensor>; a scene needs a camera")
    for other in sensors[1:]:
        draft.report.note(other.where, "left out: a scene has one camera, and the first sensor is taken")
        other.left_out()
    world = _sensor(sensors[0], draft)
    shapes = Shapes(draft, world)
    for _, emitter in scene.objects("emitter"):
        light(emitter, draft, world)
    for _, shape in scene.objects("shape"):
        if shape.kind != "shapegroup":
            shapes.shape(shape)
        else:
            draft.report.note(shape.where, 'left out: the shape "shapegroup"')
            shape.left_out()
    integrators = [integrator for _, integrator in scene.objects("integrator")]
    _integrator(integrators[0] if integrators else None, document.root.where, draft)
    for element in seen.values():
        if element.used or element is scene:
            element.leftovers()


def _sensor(element: Element, draft: Draft) -> Array:
    """Sets camera, film and samples; returns what turns Mitsuba's world into the scene's: it may be a mirror."""
    where = element.where
    if element.kind not in ("perspective", "thinlens", "orthographic"):
        raise SourceError(
            f"{where}: the sensor {shown(element.kind)} cannot be carried over; "
            "perspective, thinlens and orthographic can"
        )
    element.passed_over("shutter_open", "shutter_close")
    width, height = _film(element, draft)
    to_world = element.transform()
    axes = np.eye(3)
    pose = Pose.of(to_world, axes[2], axes[1], -axes[0], where)
    world = MIRROR if pose.mirrored else np.eye(4)
    if pose.mirrored:
        draft.report.note(where, "the camera mirrors its picture: the world is mirrored instead, x turned round")
    camera: Fields = {"kind": element.kind, **pose.fields(world)}
    for name in ("near_clip", "far_clip"):
        if name in element:
            element.number(name, 0.0)
            draft.report.note(element.at(name), f"{name} is not carried over: everything before the camera is seen")
    if element.kind == "orthographic":
        if (scale := uniform_scale(to_world)) is None:
            scale = float(np.linalg.norm(to_world[:3, 0]))
            draft.report.note(where, "an orthographic camera is scaled by x alone here")
        camera["height"] = 2 * scale * height / width
    else:
        camera["fov"] = _vertical(element, width, height)
    if element.kind == "thinlens":
        camera["kind"] = "thin_lens"
        camera["aperture_radius"] = element.number("aperture_radius", 0.0)
        camera["focus_distance"] = element.number("focus_distance", 0.0)
        if not (camera["aperture_radius"] > 0 and camera["focus_distance"] > 0):
            raise SourceError(f"{where}: a thinlens needs an aperture_radius and a focus_distance of more than 0")
    for name in ("principal_point_offset_x", "principal_point_offset_y"):
        if element.number(name, 0.0) != 0:
            draft.report.note(element.at(name), f"{name} is not carried over: the picture's middle is the axis")
    draft.scene["camera"] = camera
    samplers = [sampler for _, sampler in element.objects("sampler")]
    samples, seed = 4, 0
    if samplers:
        samples, seed = samplers[0].integer("sample_count", 4), samplers[0].integer("seed", 0)
        samplers[0].passed_over("jitter")
    draft.scene["seed"] = seed % (1 << 32)
    draft.scene["stop"] = {"kind": "samples", "samples": samples}
    return world


def _vertical(element: Element, width: int, height: int) -> float:
    """The vertical field of view, degrees: of the one along `fov_axis`, or of a focal length on 36 × 24 mm."""
    axis = element.string("fov_axis", "x")
    if "fov" in element:
        fov = element.number("fov", 0.0)
        if not 0 < fov < 180:
            raise SourceError(f"{element.at('fov')}: fov must be between 0 and 180, not {fov:g}")
    else:
        text = element.string("focal_length", "50mm")
        millimetres = number(text.removesuffix("mm"), element.at("focal_length"), "focal_length")
        if not millimetres > 0:
            raise SourceError(f"{element.at('focal_length')}: focal_length must be more than 0")
        fov, axis = math.degrees(2 * math.atan(math.hypot(36, 24) / (2 * millimetres))), "diagonal"
    sides = {
        "x": width,
        "y": height,
        "smaller": min(width, height),
        "larger": max(width, height),
        "diagonal": math.hypot(width, height),
    }
    if axis not in sides:
        raise SourceError(f"{element.at('fov_axis')}: fov_axis must be one of {', '.join(sides)}, not {shown(axis)}")
    if axis == "y" or sides[axis] == height:
        return fov
    return math.degrees(2 * math.atan(math.tan(math.radians(fov) / 2) * height / sides[axis]))


def _film(sensor: Element, draft: Draft) -> tuple[int, int]:
    films = [film for _, film in sensor.objects("film")]
    size, filters = (768, 576), []
    if films:
        film = films[0]
        size = film.integer("width", 768), film.integer("height", 576)
        filters = [inner for _, inner in film.objects("rfilter")]
        film.passed_over("pixel_format", "component_format", "file_format", "banner", "sample_border", "compensate")
    if min(size) < 1:
        raise SourceError(f"{films[0].where}: a film must be at least 1 × 1 pixels, not {size[0]} × {size[1]}")
    draft.scene["film"] = {"width": size[0], "height": size[1], "filter": _filter(filters, draft)}
    return size


def _filter(filters: list[Element], draft: Draft) -> Fields:
    if not filters:
        return {"kind": "gaussian", "deviation": 0.5}
    element = filters[0]
    match element.kind:
        case "box":
            return {"kind": "box", "radius": element.number("radius", 0.5)}
        case "tent":
            return {"kind": "tent", "radius": element.number("radius", 1.0)}
        case "gaussian":
            return {"kind": "gaussian", "deviation": element.number("stddev", 0.5)}
    draft.report.note(
        element.where,
        f"the filter {shown(element.kind)} is not carried over; a gaussian of deviation 0.5 stands for it",
    )
    return {"kind": "gaussian", "deviation": 0.5}


def _integrator(element: Element | None, where: str, draft: Draft) -> None:
    draft.scene["integrator"] = {"kind": "volumetric_path"}
    if element is None:
        draft.report.note(where, "has no integrator, and Mitsuba's default sees no media; volumetric_path does")
        return
    element.passed_over("rr_depth", "samples_per_pass", "block_size", "timeout")
    if element.kind in ("aov", "moment"):
        layers: list[str] = []
        for item in element.string("aovs", "").split(",") if element.kind == "aov" else []:
            if (layer := LAYERS.get(item.rpartition(":")[2].strip())) is None:
                draft.report.note(element.at("aovs"), f"left out: the layer {shown(item.strip())}")
            elif layer not in layers:
                layers.append(layer)
        if layers:
            draft.scene["layers"] = layers
        inner = [integrator for _, integrator in element.objects("integrator")]
        _integrator(inner[0] if inner else None, element.where, draft)
        return
    if element.kind not in ("volpath", "volpathmis", "prbvolpath"):
        draft.report.note(element.where, f"the integrator {shown(element.kind)} becomes volumetric_path")
    if element.integer("max_depth", -1) >= 0:
        draft.report.note(element.at("max_depth"), "max_depth is not carried over: paths have any length")
    if element.boolean("hide_emitters", False):
        draft.report.note(element.at("hide_emitters"), "hide_emitters is not carried over: the camera sees lights")
