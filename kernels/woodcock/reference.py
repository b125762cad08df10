"""The picture that errors are measured against, of an EXR or HDR file: with its variances, where it states them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from woodcock.film import weights
from woodcock.image import ImageError
from woodcock.picture import read_picture, read_variance
from woodcock.space import Array


@dataclass(frozen=True)
class Reference:
    """mean: (height, width, 1 or 3), linear Rec. 709 if coloured; name: as reports have it.

    variance: of the mean, the same shape; None if the file does not state it: then the reference counts as exact.
    seed: of the scene that it is a picture of, where the file states it.
    """

    mean: Array
    variance: Array | None
    name: str
    seed: int | None = None

    @classmethod
    def load(cls, path: Path) -> Reference:
        """Of an EXR, channels R, G, B or Y, and `variance.…` of them; of an HDR, its colours. Raises ImageError."""
        mean = read_picture(path).astype(np.float64)
        variance, header = read_variance(path)
        if not np.isfinite(mean).all():
            row, column, _ = (int(at[0]) for at in np.nonzero(~np.isfinite(mean)))
            raise ImageError(f"{path}: pixel ({column}, {row}) is no finite number; a reference must be finite")
        if not float(np.mean(mean @ weights(mean.shape[-1]))) > 0:
            raise ImageError(f"{path}: is black; a reference must have a mean luminance above 0")
        known = variance is not None and np.isfinite(variance).all()
        seed = header.get("seed", "")
        return cls(
            mean,
            variance.astype(np.float64) if variance is not None and known else None,
            path.name,
            int(seed) if seed.isdecimal() else None,
        )

    @property
    def height(self) -> int:
        return int(self.mean.shape[0])

    @property
    def width(self) -> int:
        return int(self.mean.shape[1])

    def independent_of(self, seed: int) -> Reference:
        """As it is for a picture of a scene with this seed.

        If that is its own, the two share samples. (I - R)² is not larger by the reference's variance then, but smaller
        by it if all of I's samples are R's: nothing is subtracted, and errors are off by its variance at most.
        """
        return replace(self, variance=None) if self.seed == seed else self

    def check(self, width: int, height: int, channels: int) -> None:
        """Can a picture of this size, with so many channels, be held against it? Raises ImageError.

        A grey picture can against one in colour: it counts as three equal channels. The other way round the reference
        does not say what is right.
        """
        if (self.width, self.height) != (width, height):
            mine = f"{self.width} × {self.height}"
            raise ImageError(f"{self.name}: is {mine} pixels; a reference must be {width} × {height}, as the film is")
        if self.mean.shape[-1] < channels:
            raise ImageError(f"{self.name}: is grey; the reference of a picture in colour must have R, G and B")
