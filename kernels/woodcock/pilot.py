"""What a few launches tell of many: the variance of a sample and the pace, and how far either may be off. Pure.

A sum of squares converges slower than the mean does, and where values have a heavy tail those that decide are not yet
in the pilot. Its tail is therefore continued by Pareto's law, the index by Hill (1975), as far as the render will see.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from woodcock.pace import GROWTH, RANGE_SECONDS
from woodcock.regression import quantile
from woodcock.space import Array

#: The chance to lie beyond one end of an interval of 95 %.
BEYOND = 0.025

#: Student's law is the normal one from here on.
MOST_FREEDOM = 200

#: Pixels of a square so wide are alike.
BESIDE = 4

#: Seconds may be so many times more or fewer for reasons that a pilot cannot see: other load on the machine, clock
#: rates that fall as a device warms, caches that a longer render fills, and above all the longest path of a launch, for
#: which short ones wait as long as long ones. Renders of the examples took 0.57 to 1.3 times what was predicted.
UNSEEN = 2.0

#: The tail is told by this share of the values: by so many of them at least, and at most.
TAIL, LEAST_TAIL, MOST_TAIL = 0.005, 20, 500

#: A pixel is compared with no less than this share of the picture's mean variance.
LEAST_SCALE = 0.5

#: A variance that may still grow by more than this has no upper bound that a pilot could tell.
UNBOUNDED = 1e4


def unseen(values: Array, count: float) -> float:
    """What the mean of positive values may gain, relative to it, once so many were seen, from those that are rare."""
    flat = values.reshape(-1)
    kept = min(max(int(TAIL * flat.size), LEAST_TAIL), MOST_TAIL, flat.size // 2)
    if kept < 1 or count <= flat.size:
        return 0.0
    top = np.sort(np.partition(flat, flat.size - kept - 1)[flat.size - kept - 1 :])
    least, tail = top[0], top[1:]
    if not least > 0:
        return 0.0
    # Hill's estimate has a standard error of 1 / √kept of itself.
    index = 1 / max(float(np.log(tail / least).mean()) * (1 + 1 / math.sqrt(kept)), 1e-9)
    expected = count * kept / flat.size
    largest, rare = (least * max(expected / chance, 1.0) ** (1 / index) for chance in (1.0, BEYOND))
    # The mean of Pareto's law up to the largest value that is likely to come.
    if abs(index - 1) < 1e-6:
        mean = least * math.log(largest / least)
    else:
        mean = least * index / (1 - index) * ((largest / least) ** (1 - index) - 1)
    gain = max(mean * kept - float(tail.sum()), 0.0) / flat.size
    return float((gain + rare / count) / flat.mean())


@dataclass(frozen=True)
class Values:
    """variance: of a sample, and luminance: mean, of every pixel of a view in each launch, (launches, height, width).

    samples: per pixel of a launch; share: of the picture's pixels, in the view; coarse: part of the mean variance that
    is none in the picture, whose pixels are narrower.
    """

    variance: Array
    luminance: Array
    samples: int
    share: float = 1.0
    coarse: float = 0.0

    @property
    def demand(self) -> float:
        """Variance of a sample over the square of the mean luminance: the samples for a relative error of 1."""
        mean = float(self.luminance.mean())
        return (float(self.variance.mean()) - self.coarse) / mean**2 if mean > 0 else math.nan

    def interval(self, samples: float) -> tuple[float, float]:
        """Where `demand` will lie after so many samples of every pixel, in 95 of 100 cases; high may be infinite."""
        if not self.demand > 0:
            return 0.0, math.inf
        mean = float(self.variance.mean())
        # The render's own estimate is off too, by its number of samples.
        seen = max(samples / self.samples / len(self.variance) / self.share, 1e-3)
        error, freedom = self._error()
        half = math.hypot(
            quantile(2 * BEYOND, freedom) * error * math.sqrt(1 + 1 / seen), math.log(mean / (mean - self.coarse))
        )
        # A pixel is held against those beside it: that the picture differs from place to place is no tail.
        beside = self.variance.sum(axis=0)
        rows, columns = (np.arange(0, size, BESIDE) for size in beside.shape)
        sums, sizes = (
            np.add.reduceat(np.add.reduceat(each, rows, axis=0), columns, axis=1)
            .repeat(BESIDE, axis=0)
            .repeat(BESIDE, axis=1)[: beside.shape[0], : beside.shape[1]]
            for each in (beside, np.full(beside.shape, float(len(self.variance))))
        )
        scale = (sums - self.variance) / np.maximum(sizes - 1, 1) + LEAST_SCALE * mean
        more = unseen(self.variance / scale, seen * self.variance.size)
        high = self.demand * (math.exp(min(half, 50.0)) + more)
        return self.demand * math.exp(-half), high if high < UNBOUNDED * self.demand else math.inf

    def _error(self) -> tuple[float, int]:
        """Standard error of log V / L², and its degrees of freedom, by how pixels change from launch to launch."""
        launches = len(self.variance)
        off = self.variance / self.variance.mean() - 2 * self.luminance / self.luminance.mean()
        squares = (off - off.mean(axis=0)) ** 2
        total, known = float(squares.sum()), 1 - 1 / launches
        if launches < 2 or total == 0:
            return (1.0 if launches < 2 else 0.0), 1
        freedom = known * total**2 / float((squares**2).sum())
        return math.sqrt(total / known) / squares.size, min(max(int(freedom), 1), MOST_FREEDOM)

    def needed(self, error: float) -> tuple[float, float, float]:
        """Samples of every pixel for a relative error, and the interval of 95 % that they lie in."""
        middle = self.demand / error**2
        low, _ = self.interval(middle)
        high = middle
        for _ in range(20):  # The more samples, the more of the tail is seen: the bound solves an equation.
            before, high = high, self.interval(high)[1] / error**2
            if not high < math.inf or abs(high - before) < 0.01 * high:
                return middle, low / error**2, high
        return middle, low / error**2, math.inf


@dataclass(frozen=True)
class Tempo:
    """seconds: per sample of every pixel; overhead: of a range, seconds; spread: half the interval of 95 % of the mean
    of log seconds."""

    seconds: float
    overhead: float
    spread: float

    def of(self, samples: float) -> float:
        """Seconds of so many samples of every pixel, range by range."""
        work = samples * self.seconds
        growing = math.log(max(min(work, RANGE_SECONDS) / self.seconds, 1.0)) / math.log(GROWTH)
        return work + self.overhead * (work / RANGE_SECONDS + growing + 1)

    def samples(self, seconds: float) -> float:
        """How many fit into so many seconds; one at least."""
        return max(1.0, seconds / (self.seconds * (1 + self.overhead / RANGE_SECONDS)))

    @property
    def half(self) -> float:
        """Half of the interval of 95 %, of log seconds."""
        return math.hypot(self.spread, math.log(UNSEEN))


def tempo(counts: Array, seconds: Array, share: float, merging: float) -> Tempo:
    """counts, seconds: samples and seconds of each launch, merging: seconds of merging one, over this share of the
    picture.

    The shortest launches tell what a launch costs before its first sample, if the others have many times as many.
    """
    least = counts == counts.min()
    chosen = ~least if not least.all() else least
    many, few, overhead = float(counts[chosen].mean()), float(counts.min()), 0.0
    if many >= 4 * few:
        each = float(seconds[chosen].mean()) / many
        overhead = (float(seconds[least].min()) - few * each) * many / (many - few)
        overhead = min(max(overhead, 0.0), float(seconds[chosen].min()) / 2)
    rates = (seconds[chosen] - overhead) / counts[chosen]
    mean = float(rates.mean())
    size = rates.size
    spread = (
        quantile(2 * BEYOND, size - 1) * float(rates.std(ddof=1)) / mean / math.sqrt(size)
        if size > 1
        else math.log(2.0)
    )
    return Tempo(mean / share, (overhead + merging) / share, spread)


def joined(middle: float, below: float, above: float) -> tuple[float, float]:
    """The interval around a number whose logarithm may be so much less and so much more."""
    return middle * math.exp(-below), middle * math.exp(above) if above < 700 else math.inf
