"""Mergeable statistics of a picture: count, mean and M2 of every pixel in float64, and which samples they hold."""

from __future__ import annotations

import zipfile
from dataclasses import astuple, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from woodcock.batches import Batches
from woodcock.faults import Faults
from woodcock.files import replacing
from woodcock.space import Array

Ranges = tuple[tuple[int, int], ...]
#: Luminance of linear Rec. 709 red, green and blue.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


class FilmError(ValueError):
    """A film that cannot be read or merged."""


@dataclass(frozen=True)
class Film:
    """count: uint32 (height, width); mean, m2: float64 (height, width, names), M2 the sum of squared deviations.

    names: channels as an EXR has them, `layers.layer_names`; those of the beauty come first and have no dot.
    ranges: the samples [start, stop) that it holds, sorted and disjoint, of all pixels or of those that needed them;
    batches: the launches that they came in.
    bound: of an integrator without random numbers, (height, width, channels), how far the beauty may be off.
    """

    count: NDArray[np.uint32]
    mean: Array
    m2: Array
    names: tuple[str, ...]
    ranges: Ranges = ()
    faults: Faults = field(default_factory=Faults)
    batches: Batches = field(default_factory=Batches)
    bound: Array | None = None

    @classmethod
    def empty(cls, width: int, height: int, names: tuple[str, ...]) -> Film:
        zeros = np.zeros((height, width, len(names)))
        return cls(np.zeros((height, width), np.uint32), zeros, zeros, names)

    @property
    def height(self) -> int:
        return int(self.mean.shape[0])

    @property
    def width(self) -> int:
        return int(self.mean.shape[1])

    @property
    def channels(self) -> int:
        """Of the beauty: 1 or 3."""
        return sum("." not in name for name in self.names)

    @property
    def samples(self) -> int:
        """Samples of a pixel that has all of them."""
        return sum(stop - start for start, stop in self.ranges)

    @property
    def mean_samples(self) -> float:
        """Samples per pixel, over all pixels."""
        return float(self.count.mean())

    @property
    def rejected(self) -> int:
        """Samples that count as zero because they were no radiance."""
        return self.faults.rejected

    @property
    def violations(self) -> int:
        """Tentative collisions where σ_t exceeded its majorant."""
        return self.faults.violations

    @property
    def deterministic(self) -> bool:
        """Without noise: its values have a bound in place of a variance."""
        return self.bound is not None

    @property
    def layers(self) -> tuple[str, ...]:
        """Names of its layers in order; the beauty's is empty."""
        return tuple(dict.fromkeys(name.rpartition(".")[0] for name in self.names))

    def layer(self, layer: str) -> Film:
        """One layer as a picture of its own, such as `order.rest`; the beauty is the layer without a name."""
        parts = [name.rpartition(".") for name in self.names]
        at = [index for index, part in enumerate(parts) if part[0] == layer]
        chosen = slice(at[0], at[-1] + 1)  # the channels of a layer are neighbours: no copy
        names = tuple(name for _, _, name in parts[chosen])
        bound = None if layer else self.bound
        return replace(self, mean=self.mean[..., chosen], m2=self.m2[..., chosen], names=names, bound=bound)

    def merge(self, other: Film) -> Film:
        """Both films' samples: Chan, Golub & LeVeque (1979). Raises FilmError if a sample would count twice."""
        for mine, its in ((self.mean.shape, other.mean.shape), (self.names, other.names)):
            if mine != its:
                raise FilmError(f"films of {mine} and {its} cannot be merged")
        ranges = join(self.ranges, other.ranges)
        total = self.count + other.count
        share = np.divide(other.count, total, out=np.zeros(total.shape), where=total > 0)[..., None]
        delta = other.mean - self.mean
        mean = delta * share
        mean += self.mean
        delta *= delta
        delta *= share * self.count[..., None]
        delta += self.m2 + other.m2
        return Film(
            total,
            mean,
            delta,
            self.names,
            ranges,
            self.faults + other.faults,
            self.batches.merge(other.batches),
            self._bound_with(other, share),
        )

    def _bound_with(self, other: Film, share: Array) -> Array | None:
        """A mean is off by no more than the mean of the bounds."""
        if not (self.samples and other.samples):
            return self.bound if self.samples else other.bound
        if self.bound is None and other.bound is None:
            return None
        if self.bound is None or other.bound is None:
            raise FilmError("a film with an error bound and one without cannot be merged")
        return self.bound * (1 - share) + other.bound * share

    def variance(self) -> Array:
        """Estimated variance of each pixel's mean, (height, width, names); NaN for fewer than 2 samples.

        0 without noise: there M2 is how values differ over a pixel, which is no error.
        """
        if self.deterministic:
            return np.zeros(self.m2.shape)
        n = self.count[..., None].astype(np.float64)
        unknown = np.full(self.m2.shape, np.nan)
        return np.asarray(np.divide(self.m2, n * (n - 1), out=unknown, where=n > 1))

    def rmse(self) -> float:
        """Root mean square error of a pixel of the beauty, its channels weighted by luminance; NaN if unknown.

        Estimated from the samples; without noise, at most this, from the bound.
        """
        squares = self.layer("").variance() if self.bound is None else self.bound**2
        return float(np.sqrt(np.mean(squares @ weights(self.channels))))

    def mean_luminance(self) -> float:
        """Of the beauty, over all pixels."""
        return float(np.mean(self.layer("").mean @ weights(self.channels)))

    def mean_luminance_error(self) -> float:
        """Estimated standard error of the mean luminance; NaN if unknown.

        Channels of a pixel share their paths, so that their errors add: at most this.
        """
        return self._of_the_mean(self.layer("").variance())

    def mean_luminance_deviation(self) -> float:
        """As `mean_luminance_error`, had every pixel one sample."""
        return self._of_the_mean(self.layer("").variance() * self.count[..., None])

    def _of_the_mean(self, variance: Array) -> float:
        deviation = np.sqrt(variance) @ weights(self.channels)
        return float(np.sqrt(np.sum(deviation**2)) / deviation.size)

    def save(self, path: Path) -> None:
        """Writes an .npz, whole or not at all."""
        spans = np.array(self.ranges, np.uint64).reshape(-1, 2)
        arrays: dict[str, Any] = {
            "count": self.count,
            "mean": self.mean,
            "m2": self.m2,
            "ranges": spans,
            "faults": self.faults.array(),
            "batches": np.array(astuple(self.batches)),
        }
        arrays |= {"names": np.array(self.names)} | ({} if self.bound is None else {"bound": self.bound})
        with replacing(path) as temporary, temporary.open("wb") as file:
            np.savez(file, **arrays)

    @classmethod
    def load(cls, path: Path) -> Film:
        """Raises FilmError for a file that is not a whole film."""
        try:
            with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
                ranges = tuple((int(start), int(stop)) for start, stop in stored["ranges"])
                launches, spread, samples, mean = (float(number) for number in stored["batches"])
                faults, batches = Faults.of(stored["faults"]), Batches(int(launches), spread, int(samples), mean)
                names = tuple(str(name) for name in stored["names"])
                bound = stored.get("bound", None)
                return cls(stored["count"], stored["mean"], stored["m2"], names, ranges, faults, batches, bound)
        # RuntimeError: of a damaged file that seems encrypted, or packed in a way that nobody knows.
        except (OSError, ValueError, KeyError, EOFError, RuntimeError, zipfile.BadZipFile) as error:
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
