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


def tiles(picture: Array, side: int = TILE) -> Array:
    """Means of (height, width) over tiles of side², the last of a row or column smaller."""
    height, width = picture.shape
    rows, columns = np.arange(0, height, side), np.arange(0, width, side)
    sums = np.add.reduceat(np.add.reduceat(picture, rows, axis=0), columns, axis=1)
    return np.asarray(sums / np.outer(np.diff([*rows, height]), np.diff([*columns, width])))


@dataclass(frozen=True)
class Batches:
    """Launches of the whole picture; those of a part of its pixels do not count here.

    count: launches; spread: Σ samples × (mean - all launches' mean)² of the picture's luminance; samples: per pixel;
    mean: luminance, of all of them.
    """

    count: int = 0
    spread: float = 0.0
    samples: int = 0
    mean: float = 0.0

    def merge(self, other: Batches) -> Batches:
        """Chan, Golub & LeVeque (1979), with one value, the picture's mean luminance, per launch."""
        total = self.samples + other.samples
        share, apart = other.samples / total if total else 0.0, other.mean - self.mean
        spread = self.spread + other.spread + apart**2 * share * self.samples
        return Batches(self.count + other.count, spread, total, self.mean + apart * share)

    def deviation(self) -> float:
        """Standard deviation of the mean luminance by one sample of every pixel; NaN for fewer than 2 launches.

        A launch of n samples has a mean of variance σ² / n, so that the spread's expectation is (count - 1) σ².
        """
        return float(np.sqrt(self.spread / (self.count - 1))) if self.count > 1 else float("nan")
