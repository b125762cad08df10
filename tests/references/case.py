"""What a scene of a reference is, and short words for the parts of ours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tests.references.mitsuba_side import Described, Mitsuba

SIZE = 48
FLOOR = [[3, 0, 0, 0], [0, 0, 3, -1.3], [0, -3, 0, 0], [0, 0, 0, 1]]  # faces +y
CEILING = [[0.8, 0, 0, 0.3], [0, 0, -1, 2], [0, 0.6, 0, 0], [0, 0, 0, 1]]  # faces -y
#: Of the unit cube of a grid: turned about y, and moved to around the origin.
PLACED = [[1.8, 0, 0.6, -1.2], [0, 2, 0, -1], [-0.6, 0, 1.8, -0.6], [0, 0, 0, 1]]
TINTED_TABLE = [0.5, 0.2, 0.1, 0.3, 0.4, 0.9, 2]  # at cosines evenly from -1 to 1
COSINES = [-1, -2 / 3, -1 / 3, 0, 1 / 3, 2 / 3, 1]
ABOVE, FRONT = (1.8, 1.4, -3.6), (0, 0.3, -4.5)


@dataclass(frozen=True)
class Case:
    """scene: JSON, its files as `inputs` names them; mitsuba: what Mitsuba's scene holds beside its camera.

    samples: of a pixel, in Mitsuba; ours: as many as make our noise no more than its.
    """

    name: str
    scene: dict[str, Any]
    camera: Callable[[Mitsuba], Described]
    mitsuba: Callable[[Mitsuba], Described]
    integrator: str = "volpath"
    samples: int = 8192
    ours: int = 4096


def perspective(origin: Any = ABOVE, target: Any = (0, 0, 0), **keys: Any) -> dict[str, Any]:
    return {"kind": "perspective", "origin": list(origin), "target": list(target), "fov": 40, **keys}


def pinhole(origin: Any = ABOVE, target: Any = (0, 0, 0)) -> Callable[[Mitsuba], Described]:
    return lambda m: m.camera("perspective", origin, target, SIZE, fov=40)


def box(low: float, high: float, **keys: Any) -> dict[str, Any]:
    return {"kind": "constant", "shape": {"kind": "box", "min": [low] * 3, "max": [high] * 3}, **keys}


def ball(center: Any, radius: float, **keys: Any) -> dict[str, Any]:
    return {"kind": "constant", "shape": {"kind": "sphere", "center": list(center), "radius": radius}, **keys}


def density(**keys: Any) -> dict[str, Any]:
    return {"kind": "grid", "file": "density.npy", "to_world": PLACED, **keys}


def rectangle(rows: Any, **material: Any) -> dict[str, Any]:
    return {"kind": "rectangle", "to_world": rows, "material": material}


def sphere(center: Any, radius: float, **material: Any) -> dict[str, Any]:
    return {"kind": "sphere", "center": list(center), "radius": radius, "material": material}


def floor(*reflectance: float) -> dict[str, Any]:
    return rectangle(FLOOR, kind="diffuse", reflectance=list(reflectance))


def constant(radiance: Any) -> dict[str, Any]:
    return {"kind": "constant", "radiance": radiance}


def lobe(g: float) -> dict[str, Any]:
    return {"kind": "henyey_greenstein", "g": g}


SKY = {"kind": "image", "file": "sky.exr"}
