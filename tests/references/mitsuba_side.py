"""Short words for Mitsuba's scene dictionaries, so that a scene reads like ours beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from tests.references import inputs

Described = dict[str, Any]
Colour = float | Sequence[float]
#: σ_t is given as this times a colour that Mitsuba takes for a reflectance.
LARGEST = 8.0
#: Of tables that stand for smooth functions: those here are within 1e-5 of theirs.
NODES = 4001


class Mitsuba:
    """Parts of a scene for the module `mi`, a variant of it chosen; files are those that `inputs` wrote to `folder`."""

    def __init__(self, mi: Any, folder: Path) -> None:
        self.mi, self.folder = mi, folder

    def camera(self, kind: str, origin: Any, target: Any, size: int, height: float = 2, **keys: Any) -> Described:
        """height: of the picture in scene units, where the kind is orthographic."""
        to_world = self.mi.ScalarTransform4f().look_at(origin=origin, target=target, up=[0, 1, 0])
        if kind == "orthographic":
            to_world = to_world @ self.mi.ScalarTransform4f().scale([height / 2, height / 2, 1])
        film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
        film["component_format"] = "float32"
        fov = {} if kind == "orthographic" else {"fov_axis": "y"}
        return {"type": kind, "to_world": to_world, "film": film, "near_clip": 1e-3, "far_clip": 1e5, **fov, **keys}

    def matrix(self, rows: Any) -> Any:
        return self.mi.ScalarTransform4f(np.array(rows, float))

    @staticmethod
    def rgb(colour: Colour) -> Described:
        return {"type": "rgb", "value": [colour] * 3 if isinstance(colour, int | float) else list(colour)}

    # Media

    def medium(self, sigma_t: Colour, albedo: Colour, phase: Described) -> Described:
        scaled = np.asarray(sigma_t) / LARGEST
        sigma = self.rgb(scaled.tolist() if scaled.ndim else float(scaled))
        return {"type": "homogeneous", "sigma_t": sigma, "albedo": self.rgb(albedo), "scale": LARGEST, "phase": phase}

    def grid_medium(self, to_world: Any, scale: Colour, albedo: Described, phase: Described) -> Described:
        """The densities of `inputs`; a scale with three numbers makes three channels."""
        values = inputs.density()[..., None] * np.asarray(scale, np.float32) / LARGEST
        sigma = self.grid(values, to_world)
        return {"type": "heterogeneous", "sigma_t": sigma, "albedo": albedo, "scale": LARGEST, "phase": phase}

    def grid(self, values: Any, to_world: Any) -> Described:
        """[z][y][x][channels] in the unit cube, placed by rows."""
        grid = self.mi.VolumeGrid(np.ascontiguousarray(values, np.float32))
        placed = self.matrix(to_world)
        return {"type": "gridvolume", "grid": grid, "to_world": placed, "wrap_mode": "clamp", "raw": True}

    def colours(self, to_world: Any, albedo: Colour) -> Described:
        """The colours of `inputs` times an albedo."""
        return self.grid(inputs.colours() * np.asarray(albedo, np.float32), to_world)

    @staticmethod
    def within(shape: Described, medium: Described) -> Described:
        """A medium that fills a shape with a boundary of its own index."""
        return {**shape, "bsdf": {"type": "null"}, "interior": medium}

    # Shapes

    def box(self, low: Any, high: Any) -> Described:
        low, high = np.array(low, float), np.array(high, float)
        rows = np.diag([*(high - low) / 2, 1])
        rows[:3, 3] = (low + high) / 2
        return {"type": "cube", "to_world": self.matrix(rows)}

    def mapped_box(self, rows: Any) -> Described:
        """The unit cube, placed by rows."""
        half = np.diag([0.5, 0.5, 0.5, 1])
        half[:3, 3] = 0.5
        return {"type": "cube", "to_world": self.matrix(np.array(rows) @ half)}

    @staticmethod
    def sphere(center: Any, radius: float) -> Described:
        return {"type": "sphere", "center": center, "radius": radius}

    def rectangle(self, rows: Any) -> Described:
        return {"type": "rectangle", "to_world": self.matrix(rows)}

    def disk(self, center: Any, normal: Any, radius: float) -> Described:
        target = np.array(center, float) + np.array(normal, float)
        up = np.eye(3)[int(np.argmin(np.abs(normal)))]
        to_world = self.mi.ScalarTransform4f().look_at(origin=center, target=target, up=up)
        return {"type": "disk", "to_world": to_world @ self.mi.ScalarTransform4f().scale([radius, radius, 1])}

    def mesh(self) -> Described:
        return {"type": "ply", "filename": str(self.folder / "body.ply"), "face_normals": True}

    # Materials and lights

    def diffuse(self, reflectance: Colour) -> Described:
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": self.rgb(reflectance)}}

    def emissive(self, colour: Colour) -> Described:
        """Keys of a shape that shines on its normal's side and reflects nothing."""
        black = {"type": "diffuse", "reflectance": self.rgb(0)}
        return {"bsdf": black, "emitter": {"type": "area", "radiance": self.rgb(colour)}}

    def constant(self, colour: Colour) -> Described:
        return {"type": "constant", "radiance": self.rgb(colour)}

    def directional(self, direction: Any, colour: Colour) -> Described:
        return {"type": "directional", "direction": direction, "irradiance": self.rgb(colour)}

    def point(self, position: Any, colour: Colour) -> Described:
        return {"type": "point", "position": position, "intensity": self.rgb(colour)}

    def spot(self, origin: Any, target: Any, colour: Colour, beam: float, cutoff: float) -> Described:
        to_world = self.mi.ScalarTransform4f().look_at(origin=origin, target=target, up=[0, 0.1, 1])
        keys = {"to_world": to_world, "intensity": self.rgb(colour), "beam_width": beam, "cutoff_angle": cutoff}
        return {"type": "spot", **keys}

    def sky(self) -> Described:
        """Mitsuba's first and last rows lie at the poles, and +z in the middle."""
        picture = inputs.sky(np.linspace(0, np.pi, inputs.HEIGHT))
        turned = self.mi.ScalarTransform4f().rotate([0, 1, 0], 180)
        return {"type": "envmap", "bitmap": self.mi.Bitmap(picture), "to_world": turned}

    def sun(self, direction: Any, colour: Colour, radius: float) -> Described:
        """A disk far away; radius: angular, degrees."""
        travel = np.array(direction, float) / np.linalg.norm(direction)
        away, alpha = 1e4, np.radians(radius)
        shining = np.asarray(colour) / (np.pi * np.sin(alpha) ** 2)
        return {**self.disk(-away * travel, travel, float(away * np.tan(alpha))), **self.emissive(shining.tolist())}


def blend(weight: float, first: Described, second: Described) -> Described:
    """weight: of the first."""
    return {"type": "blendphase", "weight": 1 - weight, "first": first, "second": second}


def hg(g: float) -> Described:
    return {"type": "hg", "g": g}


ISOTROPIC: Described = {"type": "isotropic"}
RAYLEIGH: Described = {"type": "rayleigh"}


def tabulated(values: Sequence[float]) -> Described:
    """At cosines evenly from -1 to 1."""
    return {"type": "tabphase", "values": ", ".join(map(str, values))}


def draine(g: float, alpha: float) -> Described:
    """Draine (2003) without its norm: Mitsuba normalises tables."""
    cosine = np.linspace(-1, 1, NODES)
    return tabulated(((1 + alpha * cosine**2) / (1 + g**2 - 2 * g * cosine) ** 1.5).tolist())


def mie(d: float) -> Described:
    """Jendersie & d'Eon (2023), eqs. 7 to 10, for diameters from 5 to 50 µm; the peak needs no table."""
    peak = math.exp(-0.0990567 / (d - 1.67154))
    g, alpha = math.exp(-2.20679 / (d + 3.91029) - 0.428934), math.exp(3.62489 - 8.29288 / (d + 5.52825))
    return blend(math.exp(-0.599085 / (d - 0.641583) - 0.665888), draine(g, alpha), hg(peak))
