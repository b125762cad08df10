"""A pbrt-v4 scene: camera, film, and who converts the rest.

pbrt's world is left-handed by its cameras: with y up and z forward, x is on the right. The scene is made for a camera
whose right is forward × up, so the world is mirrored, x turned round, unless its camera mirrors it back itself.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from woodcock.importing import transforms
from woodcock.importing.draft import Draft
from woodcock.importing.geometry import Fields
from woodcock.importing.pbrt.lights import light
from woodcock.importing.pbrt.parameters import Parameters
from woodcock.importing.pbrt.shapes import Shapes
from woodcock.importing.pbrt.state import Reader
from woodcock.importing.pbrt.world import Directive, World
from woodcock.importing.report import SourceError, shown
from woodcock.importing.transforms import MIRROR, Array, Pose

BLIND = ("path", "simplepath", "ao", "randomwalk", "lightpath", "sppm", "function")
X, Y, Z = np.eye(3)


def convert(path: Path, draft: Draft) -> None:
    """Reads a scene into `draft`. Raises SourceError."""
    source = Reader(path, draft.report).world
    width, height = _film(source, draft, str(path))
    world = _camera(source, draft, width, height, str(path))
    _sampler(source, draft)
    _integrator(source, draft, str(path))
    for directive in source.lights:
        light(directive, draft, world)
    shapes = Shapes(draft, source, world)
    for shape in source.shapes:
        shapes.shape(shape)
    if source.camera_medium:
        draft.report.note(
            source.options["Camera"].where,
            f"the medium {shown(source.camera_medium)} around the camera has no bounds, and is not carried over",
        )
    for parameters in source.parameters:
        parameters.leftovers()


def _made(source: World, name: str, default: str, where: str, draft: Draft) -> Directive:
    """A directive of the options, or what pbrt takes where it is missing."""
    if name in source.options:
        return source.options[name]
    parameters = Parameters(f"{name} {shown(default)}", where, draft.source.parent, draft.report)
    return Directive(default, parameters, transforms.identity())


def _film(source: World, draft: Draft, where: str) -> tuple[int, int]:
    film = _made(source, "Film", "rgb", where, draft)
    parameters = film.parameters
    parameters.passed_over("filename", "savefp16", "diagonal")
    if film.kind != "rgb":
        draft.report.note(
            film.where, f"the film {shown(film.kind)} is not carried over: a picture has red, green, blue"
        )
    width, height = parameters.integer("xresolution", 1280), parameters.integer("yresolution", 720)
    if width < 1 or height < 1:
        raise SourceError(f"{film.where}: a film must be at least 1 × 1 pixels, not {width} × {height}")
    exposure = parameters.number("exposuretime", 1.0) * parameters.number("iso", 100.0) / 100
    if exposure != 1:
        draft.report.note(
            film.where, f"the exposure is not carried over: pbrt's picture is {exposure:g} times as bright"
        )
    draft.scene["film"] = {
        "width": width,
        "height": height,
        "filter": _filter(_made(source, "PixelFilter", "gaussian", where, draft), draft),
    }
    return width, height


def _filter(made: Directive, draft: Draft) -> Fields:
    parameters = made.parameters
    default = {"box": 0.5, "gaussian": 1.5, "triangle": 2.0}.get(made.kind, 2.0)
    radius, other = (parameters.number(name, default) for name in ("xradius", "yradius"))
    if radius != other:
        draft.report.note(made.where, "the filter has its xradius along y too")
    match made.kind:
        case "box":
            return {"kind": "box", "radius": radius}
        case "triangle":
            return {"kind": "tent", "radius": radius}
        case "gaussian":
            deviation = parameters.number("sigma", 0.5)
            if radius != 4 * deviation:
                draft.report.note(
                    made.where, f"the gaussian filter ends at {4 * deviation:g} pixels, not at {radius:g}"
                )
            return {"kind": "gaussian", "deviation": deviation}
    parameters.passed_over(*parameters.found)
    draft.report.note(
        made.where, f"the filter {shown(made.kind)} is not carried over; a gaussian of deviation 0.5 stands for it"
    )
    return {"kind": "gaussian", "deviation": 0.5}


def _camera(source: World, draft: Draft, width: int, height: int, path: str) -> Array:
    """Sets the camera; returns what turns pbrt's world into the scene's."""
    made = _made(source, "Camera", "perspective", path, draft)
    parameters, where = made.parameters, made.where
    parameters.passed_over("shutteropen", "shutterclose")
    if made.kind not in ("perspective", "orthographic", "spherical"):
        raise SourceError(
            f"{where}: the camera {shown(made.kind)} cannot be carried over; "
            "perspective, orthographic and spherical can"
        )
    if made.kind == "spherical":
        pose = Pose.of(made.to_world, -X, Y, -Z, where)
    else:
        pose = Pose.of(made.to_world, Z, Y, X, where)
    world = MIRROR if pose.mirrored else np.eye(4)
    camera: Fields = {"kind": made.kind, **pose.fields(world)}
    if (scale := transforms.uniform_scale(made.to_world)) is None:
        scale = float(np.linalg.norm(made.to_world[:3, 1]))
        draft.report.note(where, "the camera's transform stretches its picture; that is not carried over")
    if made.kind == "spherical":
        parameters.passed_over("frameaspectratio", "screenwindow", "lensradius", "focaldistance")
        if parameters.string("mapping", "equalarea") != "equirectangular":
            draft.report.note(where, "the picture is one of longitude and latitude here, not equal-area")
        draft.scene["camera"] = camera
        return world
    half = _half_height(parameters, draft, width / height)
    lens, focus = parameters.number("lensradius", 0.0), parameters.number("focaldistance", 1e6)
    if made.kind == "orthographic":
        camera["height"] = 2 * half * scale
        if lens > 0:
            draft.report.note(parameters.at("lensradius"), "lensradius is not carried over: all is sharp")
    else:
        fov = parameters.number("fov", 90.0)
        if not 0 < fov < 180:
            raise SourceError(f"{parameters.at('fov')}: fov must be between 0 and 180, not {fov:g}")
        camera["fov"] = math.degrees(2 * math.atan(math.tan(math.radians(fov) / 2) * half))
        if lens > 0:
            camera |= {"kind": "thin_lens", "aperture_radius": lens * scale, "focus_distance": focus * scale}
    draft.scene["camera"] = camera
    return world


def _half_height(parameters: Parameters, draft: Draft, aspect: float) -> float:
    """Half the height of pbrt's screen, whose shorter half side is 1 unless a window is given."""
    frame = parameters.number("frameaspectratio", aspect)
    if not frame > 0:
        raise SourceError(f"{parameters.at('frameaspectratio')}: frameaspectratio must be more than 0, not {frame:g}")
    half = 1.0 if frame > 1 else 1 / frame
    window = parameters.numbers("screenwindow")
    if window is None:
        if not math.isclose(frame, aspect, rel_tol=1e-3):
            draft.report.note(parameters.at("frameaspectratio"), "pixels are square here: the width follows the film")
        return half
    if window.size != 4 or not (window[1] > window[0] and window[3] > window[2]):
        raise SourceError(f"{parameters.at('screenwindow')}: screenwindow must hold x0 x1 y0 y1, each pair rising")
    x0, x1, y0, y1 = window.tolist()
    if abs(x0 + x1) > 1e-6 * (x1 - x0) or abs(y0 + y1) > 1e-6 * (y1 - y0):
        draft.report.note(parameters.at("screenwindow"), "the screen window is brought to the middle")
    if not math.isclose((x1 - x0) / (y1 - y0), aspect, rel_tol=1e-3):
        draft.report.note(parameters.at("screenwindow"), "pixels are square here: the width follows the film")
    return float(y1 - y0) / 2


def _sampler(source: World, draft: Draft) -> None:
    samples, seed = 16, 0
    if "Sampler" in source.options:
        sampler = source.options["Sampler"]
        parameters = sampler.parameters
        parameters.passed_over("randomization", "jitter")
        samples, seed = parameters.integer("pixelsamples", 16), parameters.integer("seed", 0)
        if sampler.kind == "stratified":
            samples = parameters.integer("xsamples", 4) * parameters.integer("ysamples", 4)
    draft.scene["seed"] = seed % (1 << 32)
    draft.scene["stop"] = {"kind": "samples", "samples": samples}


def _integrator(source: World, draft: Draft, path: str) -> None:
    made = _made(source, "Integrator", "volpath", path, draft)
    parameters = made.parameters
    parameters.passed_over("lightsampler", "rrthreshold")
    draft.scene["integrator"] = {"kind": "volumetric_path"}
    if made.kind in BLIND:
        draft.report.note(made.where, f"the integrator {shown(made.kind)} sees no media; volumetric_path does")
    depth = parameters.integer("maxdepth", 5)
    draft.report.note(
        parameters.at("maxdepth"), f"paths have any length here; pbrt's end after {depth} scatterings: it is darker"
    )
    if parameters.boolean("regularize", False):
        draft.report.note(parameters.at("regularize"), "regularize is not carried over: nothing is roughened")
    if "Accelerator" in source.options:
        accelerator = source.options["Accelerator"].parameters
        accelerator.passed_over(*accelerator.found)
