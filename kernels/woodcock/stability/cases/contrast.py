"""Density contrasts of 1e12 between neighbours, one hot voxel in an empty grid, and grids a voxel wide."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from woodcock.stability import exact
from woodcock.stability.case import Case, Description, by_hits, exactly, white
from woodcock.stability.scenes import LOOPS, Kind, Values, grid, noise, seen

GROUP = "grids"


def _checkers(low: float, high: float) -> Values:
    z, y, x = np.indices((4, 4, 4))
    return np.where((x + y + z) % 2 == 0, high, low).astype(np.float32)


def _layers(low: float, high: float) -> Values:
    return np.array([low, high, low, high], np.float32).reshape(4, 1, 1)


def _hot(value: float) -> Values:
    values = np.zeros((9, 9, 9), np.float32)
    values[4, 5, 3] = value
    return values


#: By σ_t. Under one majorant for all, a path takes as many steps as the densest voxel has mean free paths.
CONTRASTS: dict[str, Values] = {
    "contrast 1e12, thin": _checkers(1e-12, 1.0),
    "contrast 1e12, dense": _checkers(1e-7, 1e5),
    "contrast 1e12, layers": _layers(1e-12, 1.0),
    "contrast 1e38, layers": _layers(1e-38, 1.0),
    "a hot voxel of σ = 1": _hot(9.0),
    "a hot voxel of σ = 1e5": _hot(1e5),
    "a voxel of σ = 1e-6": _hot(1e-6),
}
SHAPES = {
    "one voxel": noise(1, 1, 1) + 0.5,
    "1 × 1 × 1000 voxels": noise(1000, 1, 1),
    "1 × 1000 × 1 voxels": noise(1, 1000, 1),
    "1000 × 1 × 1 voxels": noise(1, 1, 1000),
    "2 × 2 × 2 voxels": noise(2, 2, 2),
    "halves, 7 × 5 × 3 voxels": noise(3, 5, 7).astype(np.float16),
    "bytes, 5 × 5 × 5 voxels": (3 * noise(5, 5, 5)).astype(np.uint8),
    "halves without all digits": (noise(3, 5, 7) * 1e-6).astype(np.float16),
}


def _scene(values: Values, scale: float, albedo: float, keys: Kind, folder: Path) -> Description:
    return seen(grid(folder, values, albedo, scale=scale)) | keys


def _nearest(values: Values, scale: float, keys: Kind, folder: Path) -> Description:
    return seen(grid(folder, values, 0.0, scale=scale, interpolation="nearest")) | keys


def _through(values: Values, scale: float) -> exact.Array:
    return exact.through_columns(scale * values.astype(float), exact.middles(8), exact.middles(8))


def _through_nearest(values: Values, scale: float) -> exact.Array:
    columns = scale * values.astype(float).mean(axis=0)
    at = [np.floor(exact.middles(8) * n).astype(int) for n in columns.shape]
    return np.asarray(np.exp(-columns[np.ix_(*at)]))


def _mean(values: Values, scale: float) -> float:
    return exact.through_columns_mean(scale * values.astype(float))


def _cases() -> Iterator[Case]:
    grids = {name: (values, 1.0) for name, values in CONTRASTS.items()}
    grids |= {name: (values, 2.0) for name, values in SHAPES.items()}
    grids["halves without all digits"] = (SHAPES["halves without all digits"], 2e6)
    for name, (values, scale) in grids.items():
        scene, right = partial(_scene, values, scale, 0.0), partial(_through, values, scale)
        yield exactly(GROUP, f"{name}, through", partial(scene, {}), right)
        nearest = partial(_nearest, values, scale, {})
        yield exactly(GROUP, f"{name}, through nearest", nearest, partial(_through_nearest, values, scale))
        for loop, keys in LOOPS.items():
            hits = partial(scene, keys)
            yield by_hits(GROUP, f"{name}, through, {loop}", hits, partial(_mean, values, scale), (0, 64))
            samples = (0, 4) if float(values.max()) * scale < 1e4 else (0, 1)
            yield white(GROUP, f"{name}, furnace, {loop}", partial(_scene, values, scale, 1.0, keys), samples)


CASES = tuple(_cases())
