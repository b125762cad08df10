"""Optical depth from 1e-8 to 1e8: what gets through, what a source function of 1 adds, what comes back of a beam."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from woodcock.stability import exact
from woodcock.stability.case import Case, Description, by_hits, exactly, on_average
from woodcock.stability.scenes import LOOPS, PATHS, Kind, beam, cube, decades, grid, noise, parallel, seen, square

GROUP = "optical depth"
LAYERS = noise(5, 1, 1)
MANY = square(16)


def _cube(tau: float, keys: Kind, folder: Path) -> Description:
    return seen(cube(tau, 0)) | keys


def _layers(tau: float, albedo: float, keys: Kind, folder: Path) -> Description:
    """Unequal ones: the mean of what is interpolated, and clamped at both ends, is the mean of the voxels."""
    return seen(grid(folder, LAYERS, albedo, scale=tau / float(LAYERS.mean(dtype=float)))) | keys


def _glowing(tau: float, keys: Kind, folder: Path) -> Description:
    return seen(cube(tau, 0, emission={"kind": "constant", "epsilon": tau}), lights=[]) | keys


#: Of so small an albedo that light scatters once, to a part in a million; seen along the beam, it goes back as it came.
FAINT = 1e-6
#: From either side: places near the scene's origin have more digits than others.
LIT: dict[str, Kind] = {
    "": {"lights": [beam(4 * math.pi / FAINT)]},
    " from behind": {
        "lights": [beam(4 * math.pi / FAINT, (0, 0, -1))],
        "camera": parallel((0.5, 0.5, 2), (0.5, 0.5, 0.5), 1),
    },
}


def _back(tau: float) -> float:
    return exact.slab(2 * tau) / 2


def _cases() -> Iterator[Case]:
    for tau in sorted([*decades(-8, 8), 87.0, 103.0]):
        name, through = f"τ = {tau:g}", partial(math.exp, -tau)
        yield exactly(GROUP, f"{name}, through a cube", partial(_cube, tau, {}), through)
        yield exactly(GROUP, f"{name}, through a grid", partial(_layers, tau, 0, {}), through)
        yield exactly(GROUP, f"{name}, B (1 - e^-τ)", partial(_glowing, tau, {}), partial(exact.slab, tau))
    for tau in decades(-8, 8, 2):
        name, through = f"τ = {tau:g}", partial(math.exp, -tau)
        for loop, keys in LOOPS.items():
            yield by_hits(GROUP, f"{name}, through a cube, {loop}", partial(_cube, tau, keys | MANY), through, (0, 64))
            layers = partial(_layers, tau, 0, keys | MANY)
            yield by_hits(GROUP, f"{name}, through a grid, {loop}", layers, through, (0, 64))
        yield on_average(
            GROUP,
            f"{name}, B (1 - e^-τ), paths",
            partial(_glowing, tau, PATHS | MANY),
            partial(exact.slab, tau),
            (0, 64),
            spread=exact.slab_spread(tau),
        )
    for tau in (0.01, 1, 100, 1e4, 1e6, 1e8):
        for loop, keys in LOOPS.items():
            for where, lit in LIT.items():
                yield on_average(
                    GROUP,
                    f"τ = {tau:g}, a beam's way back{where}, {loop}",
                    partial(_layers, tau, FAINT, keys | lit | MANY),
                    partial(_back, tau),
                    (0, 256),
                    unresolved=f"places in mean free paths of {1 / tau:g} of the scene",
                )


CASES = tuple(_cases())
