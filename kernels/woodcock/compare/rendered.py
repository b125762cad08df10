"""A finished picture as its EXR states it: with its noise, or its bounds, and which random numbers it used."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

import numpy as np

from woodcock.film import FilmError, Ranges, join
from woodcock.image import ImageError
from woodcock.picture import read_beside, read_picture
from woodcock.space import Array


@dataclass(frozen=True)
class Rendered:
    """mean: (height, width, 1 or 3). variance: of the mean, the same shape, None where it is not known; bound: how far
    the mean may be off, of a picture that was computed without random numbers, else None.

    seed, ranges: which random numbers it used; samples: per pixel, on average; None where the file does not say.
    """

    mean: Array
    variance: Array | None
    bound: Array | None = None
    seed: int | None = None
    ranges: Ranges = ()
    samples: float | None = None

    @classmethod
    def load(cls, path: Path) -> Self:
        """Of an EXR that a render wrote. Raises ImageError."""
        mean = read_picture(path).astype(np.float64)
        if not np.isfinite(mean).all():
            row, column, _ = (int(at[0]) for at in np.nonzero(~np.isfinite(mean)))
            raise ImageError(f"{path}: pixel ({column}, {row}) is no finite number; only finite pictures are compared")
        variance, header = read_beside(path, "variance")
        bound, _ = read_beside(path, "bound")
        known = variance is not None and not np.isnan(variance).any()
        return cls(
            mean,
            variance.astype(np.float64) if variance is not None and known else None,
            None if bound is None else bound.astype(np.float64),
            int(header["seed"]) if "seed" in header else None,
            tuple((start, stop) for start, stop in json.loads(header.get("sampleRanges", "[]"))),
            float(header["samples"]) if "samples" in header else None,
        )

    def shares_with(self, other: Rendered) -> bool:
        """Do the two use the same random numbers, as far as is known? Those without noise use none."""
        if self.bound is not None or other.bound is not None:
            return False
        if None not in (self.seed, other.seed) and self.seed != other.seed:
            return False
        try:
            join(self.ranges, other.ranges)
        except FilmError:
            return True
        return not (self.ranges and other.ranges)

    def beside(self, other: Rendered) -> Rendered:
        """As it is next to another one: where that is in colour, a grey picture counts as three equal channels.

        Raises ImageError for one of another size.
        """
        (height, width), (its_height, its_width) = self.mean.shape[:2], other.mean.shape[:2]
        if (height, width) != (its_height, its_width):
            raise ImageError(f"{width} × {height} and {its_width} × {its_height} pixels cannot be compared")
        shape = np.broadcast_shapes(self.mean.shape, other.mean.shape)
        wide = [None if one is None else np.broadcast_to(one, shape) for one in (self.variance, self.bound)]
        return replace(self, mean=np.broadcast_to(self.mean, shape), variance=wide[0], bound=wide[1])
