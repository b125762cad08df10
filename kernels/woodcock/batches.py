"""Batch means: how far the mean of a picture, or of a part of it, may be off, by how the means of its launches differ.

The variance of a pixel takes its samples for independent. Means of whole launches over whole tiles say the same only if
pixels and launches are independent too: a generator whose streams correlate, or a range that counts twice, shows here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from woodcock.space import Array

#: Side of a tile, pixels.
TILE = 32


def tiles(picture: Array) -> Array:
    """Means of (height, width) over tiles of TILE², the last of a row or column smaller."""
    height, width = picture.shape
    rows, columns = np.arange(0, height, TILE), np.arange(0, width, TILE)
    sums = np.add.reduceat(np.add.reduceat(picture, rows, axis=0), columns, axis=1)
    return np.asarray(sums / np.outer(np.diff([*rows, height]), np.diff([*columns, width])))


@dataclass(frozen=True)
class Batches:
    """count: launches; spread: Σ samples × (mean - all launches' mean)² of the whole picture's luminance."""

    count: int = 0
    spread: float = 0.0

    def merge(self, other: Batches, means: tuple[float, float], samples: tuple[int, int]) -> Batches:
        """Chan, Golub & LeVeque (1979), with one value, the picture's mean luminance, per launch.

        means, samples: of the two pictures so far.
        """
        total = sum(samples)
        between = (means[1] - means[0]) ** 2 * samples[0] * samples[1] / total if total else 0.0
        return Batches(self.count + other.count, self.spread + other.spread + between)

    def standard_error(self, samples: int) -> float:
        """Of the picture's mean luminance after so many samples per pixel; NaN for fewer than 2 launches.

        A launch of n samples has a mean of variance σ² / n, so that the spread's expectation is (count - 1) σ².
        """
        if self.count < 2:
            return float("nan")
        return float(np.sqrt(self.spread / (self.count - 1) / samples))
