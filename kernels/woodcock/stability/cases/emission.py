"""Emission and lights of 1e±20 and more, emission where σ_t goes to 0, and emission in stiff grids."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from woodcock.stability import exact
from woodcock.stability.case import Case, Description, exactly, on_average
from woodcock.stability.scenes import LOOPS, PATHS, Kind, Values, cube, grid, noise, seen, sky, square, stored

GROUP = "emission"
HOT = np.zeros((5, 5, 5), np.float32)
HOT[2, 3, 1] = 1.0
COLUMNS = {
    "contrast 1e12": np.array([1e-7, 1e5, 1e-7, 1e5], np.float32),
    "rising to 1e6": np.array([1e-6, 1e-3, 1.0, 1e3, 1e6], np.float32),
    "falling from 1e6": np.array([1e6, 1e3, 1.0, 1e-3, 1e-6], np.float32),
    "noise of τ = 1e3": (2000 * noise(40)).astype(np.float32),
}


def _glowing(sigma: float, epsilon: float, keys: Kind, folder: Path) -> Description:
    return seen(cube(sigma, 0, emission={"kind": "constant", "epsilon": epsilon}), lights=[]) | keys


def _lit(radiance: float, keys: Kind, folder: Path) -> Description:
    return seen(cube(2.0, 0), lights=[sky(radiance)]) | keys


def _hot(scale: float, keys: Kind, folder: Path) -> Description:
    """An emission grid in a medium that is as good as empty."""
    emission = {"kind": "grid", "file": stored(folder, HOT), "scale": scale}
    return seen(grid(folder, np.ones((1, 1, 1), np.float32), 0, scale=1e-30, emission=emission), lights=[]) | keys


def _column(values: Values, folder: Path) -> Description:
    emission = {"kind": "constant", "epsilon": 1.0}
    return seen(grid(folder, values.reshape(-1, 1, 1), 0, emission=emission), lights=[])


def _thin(sigma: float) -> float:
    return exact.slab(sigma) / sigma if sigma > 0 else 1.0


def _cases() -> Iterator[Case]:
    for power in (1e-30, 1e-20, 1e-10, 1e10, 1e20, 1e30):
        right = partial(lambda p: exact.slab(2) * p / 2, power)
        yield exactly(GROUP, f"ε = {power:g}", partial(_glowing, 2.0, power, {}), right, power)
        yield on_average(GROUP, f"ε = {power:g}, paths", partial(_glowing, 2.0, power, PATHS), right, (0, 256))
        through = partial(lambda p: (1 - exact.slab(2)) * p, power)
        yield exactly(GROUP, f"a sky of {power:g}", partial(_lit, power, {}), through, power)
        for loop, keys in LOOPS.items():
            yield on_average(GROUP, f"a sky of {power:g}, {loop}", partial(_lit, power, keys), through, (0, 256))
        hot = partial(lambda p: p * exact.column_means(HOT, exact.middles(8), exact.middles(8)), power)
        yield exactly(GROUP, f"a hot voxel of ε = {power:g}", partial(_hot, power, {}), hot, power)
        # Along a ray that starts in a voxel's middle: every piece of it is asked for ε at one place.
        mean = partial(lambda p: p * float(HOT.mean(dtype=float)), power)
        yield on_average(
            GROUP, f"a hot voxel of ε = {power:g}, paths", partial(_hot, power, PATHS | square(16)), mean, (0, 256)
        )
    for sigma in (0.0, 1e-300, 1e-38, 1e-20, 1e-12, 1e-6, 1e-3, 1.0):
        right = partial(_thin, sigma)
        yield exactly(GROUP, f"ε = 1, σ = {sigma:g}", partial(_glowing, sigma, 1.0, {}), right)
        spread = exact.slab_spread(sigma) / sigma if sigma > 0 else 0.0
        paths = partial(_glowing, sigma, 1.0, PATHS)
        yield on_average(GROUP, f"ε = 1, σ = {sigma:g}, paths", paths, right, (0, 256), spread=spread)
    for name, values in COLUMNS.items():
        right = partial(exact.emitted, values.astype(float))
        yield exactly(GROUP, f"ε = 1 in a grid, {name}", partial(_column, values), right)


CASES = tuple(_cases())
