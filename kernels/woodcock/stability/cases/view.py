"""Cameras up to a million object sizes away, in the object, on its face, and of extreme angles."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from woodcock.stability import exact
from woodcock.stability.case import Case, Description, by_hits, exactly
from woodcock.stability.scenes import FULL, LOOPS, Kind, Point, ball, cube, decades, field_of_view, parallel, seen

GROUP = "distance of the camera"


def _looking(kind: str, origin: Point, target: Point, **keys: object) -> Kind:
    return {"kind": kind, "origin": list(origin), "target": list(target), "up": [0, -1, 0], **keys}


def _perspective(distance: float, half_height: float) -> Kind:
    """From in front of the ball of diameter 1 around the origin."""
    return _looking("perspective", (0, 0, -distance), (0, 0, 0), fov=field_of_view(half_height, distance))


def _ball(camera: Kind, keys: Kind, folder: Path) -> Description:
    return seen(ball(2.0, 0, 0.5, (0, 0, 0)), camera=camera) | keys


def _cube(camera: Kind, keys: Kind, folder: Path) -> Description:
    return seen(cube(2.0, 0, 1.0, (-0.5, -0.5, -0.5)), camera=camera) | keys


def _through_ball(distance: float, half_height: float) -> exact.Array:
    """(8, 8), of the middles of pixels: rays from (0, 0, -distance) through (x, y, 0)."""
    x = (2 * exact.middles(8) - 1) * half_height
    squared = x[:, None] ** 2 + x**2
    # Distance of the ray from the centre: that of a triangle's corner from the opposite side.
    nearest = distance * np.sqrt(squared) / np.sqrt(squared + distance**2)
    return np.exp(-2.0 * 2 * np.sqrt(0.25 - nearest**2))


def _cases() -> Iterator[Case]:
    for distance in [0.75, *decades(0, 6), 1e9, 1e12]:
        name, half = f"{distance:g} sizes", 0.25
        scene = partial(_ball, _perspective(distance, half))
        yield exactly(GROUP, f"{name}, through a ball", partial(scene, {}), partial(_through_ball, distance, half))
        if distance >= 1e3:  # where rays are parallel to 1e-7
            for loop, keys in LOOPS.items():
                cube_ = partial(_cube, _perspective(distance, half), keys)
                yield by_hits(GROUP, f"{name}, through a cube, {loop}", cube_, lambda: math.exp(-2), (0, 256))
    others = {
        "parallel rays from 1e6 sizes": parallel((0, 0, -1e6), (0, 0, 0), 0.5),
        "parallel rays from 1e12 sizes": parallel((0, 0, -1e12), (0, 0, 0), 0.5),
        "a lens at 1e6 sizes": _looking(
            "thin_lens", (0, 0, -1e6), (0, 0, 0), fov=field_of_view(0.25, 1e6), aperture_radius=0.01
        ),
        "1e-6 before the face": _looking("perspective", (0.1, 0.2, -0.500001), (0.1, 0.2, 0), fov=1e-3),
        "on the face": _looking("perspective", (0.1, 0.2, -0.5), (0.1, 0.2, 0), fov=1e-3),
    }
    for name, camera in others.items():
        yield exactly(GROUP, f"{name}, through a cube", partial(_cube, camera, {}), lambda: math.exp(-2))
        for loop, keys in LOOPS.items():
            if camera["kind"] != "thin_lens" or keys is FULL:
                yield by_hits(GROUP, f"{name}, {loop}", partial(_cube, camera, keys), lambda: math.exp(-2), (0, 256))
    inside = {
        "in the middle of a ball, all around": _looking("spherical", (0, 0, 0), (0, 0, 1)),
        "in the middle of a ball, 179.9°": _looking("perspective", (0, 0, 0), (0, 0, 1), fov=179.9),
        "in the middle of a ball, 1e-6°": _looking("perspective", (0, 0, 0), (0, 0, 1e-9), fov=1e-6),
    }
    for name, camera in inside.items():
        yield exactly(GROUP, name, partial(_ball, camera, {}), lambda: math.exp(-1))
        for loop, keys in LOOPS.items():
            yield by_hits(GROUP, f"{name}, {loop}", partial(_ball, camera, keys), lambda: math.exp(-1), (0, 256))


CASES = tuple(_cases())
