"""Scale of σ_t from 1e-6 to 1e6, in media as large as 1."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from woodcock.stability import exact
from woodcock.stability.case import Case, Description, exactly, white
from woodcock.stability.scenes import LOOPS, Kind, cube, decades, grid, noise, seen

GROUP = "scale of σ"
VALUES = noise(3, 5, 4)
EXACT = VALUES.astype(float)


def _uniform(sigma: float, albedo: float, keys: Kind, folder: Path) -> Description:
    return seen(cube(sigma, albedo)) | keys


def _uneven(sigma: float, albedo: float, keys: Kind, folder: Path) -> Description:
    return seen(grid(folder, VALUES, albedo, scale=sigma)) | keys


def _through(sigma: float) -> exact.Array:
    return exact.through_columns(EXACT * sigma, exact.middles(8), exact.middles(8))


def _cases() -> Iterator[Case]:
    for sigma in decades(-6, 6):
        name = f"σ = {sigma:g}"
        # Of the densest few paths suffice: some get far in, and stay for the square of how far.
        samples = (0, 4) if sigma < 1e4 else (0, 1)
        for loop, keys in LOOPS.items():
            yield white(GROUP, f"{name}, furnace of a cube, {loop}", partial(_uniform, sigma, 1.0, keys), samples)
            yield white(GROUP, f"{name}, furnace of a grid, {loop}", partial(_uneven, sigma, 1.0, keys), samples)
        uneven = partial(_uneven, sigma, 0.0, {})
        yield exactly(GROUP, f"{name}, through a grid", uneven, partial(_through, sigma))


CASES = tuple(_cases())
