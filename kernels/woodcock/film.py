"""Mergeable statistics of a picture: count, mean and M2 of every pixel in float64, and which samples they hold."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from woodcock.files import replacing
from woodcock.space import Array

Ranges = tuple[tuple[int, int], ...]
#: Luminance of linear Rec. 709 red, green and blue.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


class FilmError(ValueError):
    """A film that cannot be read or merged."""


@dataclass(frozen=True)
class Film:
    """count: uint32 (height, width); mean, m2: float64 (height, width, channels), M2 the sum of squared deviations.

    ranges: the samples [start, stop) that it holds, sorted and disjoint; rejected: samples that were NaN, infinite or
    negative and count as zero; violations: tentative collisions where the density exceeded the majorant.
    """

    count: NDArray[np.uint32]
    mean: Array
    m2: Array
    ranges: Ranges = ()
    rejected: int = 0
    violations: int = 0

    @classmethod
    def empty(cls, width: int, height: int, channels: int) -> Film:
        zeros = np.zeros((height, width, channels))
        return cls(np.zeros((height, width), np.uint32), zeros, zeros)

    @property
    def height(self) -> int:
        return int(self.mean.shape[0])

    @property
    def width(self) -> int:
        return int(self.mean.shape[1])

    @property
    def channels(self) -> int:
        return int(self.mean.shape[2])

    @property
    def samples(self) -> int:
        """Samples per pixel."""
        return sum(stop - start for start, stop in self.ranges)

    def merge(self, other: Film) -> Film:
        """Both films' samples: Chan, Golub & LeVeque (1979). Raises FilmError if a sample would count twice."""
        if self.mean.shape != other.mean.shape:
            raise FilmError(f"films of {self.mean.shape} and {other.mean.shape} cannot be merged")
        ranges = join(self.ranges, other.ranges)
        total = self.count + other.count
        share = np.divide(other.count, total, out=np.zeros(total.shape), where=total > 0)[..., None]
        delta = other.mean - self.mean
        return Film(
            total,
            self.mean + delta * share,
            self.m2 + other.m2 + delta**2 * (share * self.count[..., None]),
            ranges,
            self.rejected + other.rejected,
            self.violations + other.violations,
        )

    def variance(self) -> Array:
        """Estimated variance of each pixel's mean, (height, width, channels); NaN for fewer than 2 samples."""
        n = self.count[..., None].astype(np.float64)
        unknown = np.full(self.m2.shape, np.nan)
        return np.asarray(np.divide(self.m2, n * (n - 1), out=unknown, where=n > 1))

    def rmse(self) -> float:
        """Estimated root mean square error of a pixel, its channels weighted by luminance; NaN if unknown."""
        return float(np.sqrt(np.mean(self.variance() @ weights(self.channels))))

    def mean_luminance(self) -> float:
        return float(np.mean(self.mean @ weights(self.channels)))

    def save(self, path: Path) -> None:
        """Writes an .npz, whole or not at all."""
        facts = np.array([self.rejected, self.violations], np.uint64)
        spans = np.array(self.ranges, np.uint64).reshape(-1, 2)
        with replacing(path) as temporary, temporary.open("wb") as file:
            np.savez(file, count=self.count, mean=self.mean, m2=self.m2, ranges=spans, facts=facts)

    @classmethod
    def load(cls, path: Path) -> Film:
        """Raises FilmError for a file that is not a whole film."""
        try:
            with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
                ranges = tuple((int(start), int(stop)) for start, stop in stored["ranges"])
                rejected, violations = (int(fact) for fact in stored["facts"])
                return cls(stored["count"], stored["mean"], stored["m2"], ranges, rejected, violations)
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise FilmError(f"{path}: not a film ({error})") from None


def weights(channels: int) -> Array:
    return LUMINANCE if channels == 3 else np.ones(1)


def join(a: Ranges, b: Ranges) -> Ranges:
    """The union of two sets of samples, neighbours joined. Raises FilmError if they share a sample."""
    joined: list[tuple[int, int]] = []
    for start, stop in sorted([*a, *b]):
        if joined and start < joined[-1][1]:
            raise FilmError(f"samples {start} to {min(stop, joined[-1][1])} would count twice")
        if joined and start == joined[-1][1]:
            joined[-1] = (joined[-1][0], stop)
        else:
            joined.append((start, stop))
    return tuple(joined)
