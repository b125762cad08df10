"""Objects from 1e-12 to 1e12 large, flat ones, and ones far from the scene's origin."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from woodcock.stability import exact
from woodcock.stability.case import Case, Description, by_hits, exactly, on_average, white
from woodcock.stability.scenes import (
    LOOPS,
    PATHS,
    Kind,
    Point,
    beam,
    block,
    cube,
    decades,
    grid,
    noise,
    parallel,
    seen,
    square,
)

GROUP = "object size"
VALUES = noise(3, 5, 4)
ORIGIN = (0.0, 0.0, 0.0)
#: A medium of τ = 2 along the view.
DEPTH = 2.0


def _uneven(size: float, corner: Point, keys: Kind, folder: Path) -> Description:
    medium = grid(folder, VALUES, 0.0, size, corner, scale=DEPTH / size)
    return seen(medium, size=size, corner=corner) | keys


def _uniform(size: float, albedo: float, keys: Kind, folder: Path) -> Description:
    return seen(cube(DEPTH / size, albedo, size), size=size) | keys


def _glowing(size: float, keys: Kind, folder: Path) -> Description:
    glow = {"kind": "constant", "epsilon": DEPTH / size}
    return seen(cube(DEPTH / size, 0, size, emission=glow), size=size, lights=[]) | keys


def _lit(size: float, keys: Kind, folder: Path) -> Description:
    return _uniform(size, 1e-6, {"lights": [beam(4e6 * math.pi)], **square(16)} | keys, folder)


def _flat(size: Point, albedo: float, keys: Kind, folder: Path) -> Description:
    """A block of τ = 2 along z, seen by its middle."""
    x, y, z = size
    shortest = min(size)
    camera = parallel((x / 2, y / 2, -z), (x / 2, y / 2, z / 2), shortest / 4)
    return seen(block(DEPTH / z, albedo, ORIGIN, size), camera=camera) | keys


def _through() -> exact.Array:
    return exact.through_columns(DEPTH * VALUES.astype(float), exact.middles(8), exact.middles(8))


def _mean() -> float:
    return exact.through_columns_mean(DEPTH * VALUES.astype(float))


def _cases() -> Iterator[Case]:
    for size in decades(-12, 12, 3):
        name = f"size {size:g}"
        yield exactly(GROUP, f"{name}, through a grid", partial(_uneven, size, ORIGIN, {}), _through)
        yield exactly(
            GROUP, f"{name}, B (1 - e^-τ)", partial(_glowing, size, {}), partial(exact.slab, DEPTH), light=1.0
        )
        glowing = partial(_glowing, size, PATHS)
        yield on_average(GROUP, f"{name}, B (1 - e^-τ), paths", glowing, partial(exact.slab, DEPTH), (0, 256))
        for loop, keys in LOOPS.items():
            # The means of pixels are those of the depth over them, not that of their middles.
            yield by_hits(
                GROUP, f"{name}, through a grid, {loop}", partial(_uneven, size, ORIGIN, keys), _mean, (0, 256)
            )
            yield white(GROUP, f"{name}, furnace, {loop}", partial(_uniform, size, 1.0, keys))
            back = partial(_lit, size, keys)
            yield on_average(
                GROUP, f"{name}, a beam's way back, {loop}", back, lambda: exact.slab(2 * DEPTH) / 2, (0, 64)
            )
    for size in (1e-12, 1.0, 1e12):
        far = (1e6 * size, -1e6 * size, 1e6 * size)
        name = f"size {size:g}, a million sizes from the scene's origin"
        yield exactly(GROUP, f"{name}, through a grid", partial(_uneven, size, far, {}), _through)
        for loop, keys in LOOPS.items():
            yield by_hits(GROUP, f"{name}, {loop}", partial(_uneven, size, far, keys), _mean, (0, 256))
    for sides in ((1.0, 1.0, 1e-6), (1e6, 1e6, 1.0), (1.0, 1e6, 1.0), (1e-6, 1.0, 1e6)):
        name = f"a block of {sides[0]:g} × {sides[1]:g} × {sides[2]:g}"
        yield exactly(GROUP, f"{name}, through", partial(_flat, sides, 0.0, {}), lambda: math.exp(-DEPTH))
        for loop, keys in LOOPS.items():
            yield by_hits(
                GROUP, f"{name}, {loop}", partial(_flat, sides, 0.0, keys), lambda: math.exp(-DEPTH), (0, 256)
            )
            yield white(GROUP, f"{name}, furnace, {loop}", partial(_flat, sides, 1.0, keys), (0, 1))


CASES = tuple(_cases())
