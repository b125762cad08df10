"""Do variants show the same picture? Means over the whole and over parts of it, two variants at a time.

Two that disagree cannot both be right. Where the truth is known those that miss it are wrong; else those that the
larger part, more than half of all, does not agree with.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from woodcock.certificate import MOST_DRIFT
from woodcock.film import Film, weights
from woodcock.reference import Reference
from woodcock.space import Array

#: Parts of a picture along each side, beside the whole.
PARTS = 4
#: Probability that any of the tests of a comparison finds a disagreement by chance.
FAMILY_WISE = 1e-3


class Mean(NamedTuple):
    """Of the luminance over a part of a picture: its standard error, and what it may be off by beside that."""

    value: float
    error: float
    bound: float


def means(film: Film) -> list[Mean]:
    """Of the whole, then of the parts, row by row. Without noise, the samples of a pixel still differ over it."""
    beauty, factors = film.layer(""), weights(film.channels)
    n = film.count[..., None].astype(float)
    variance = np.divide(beauty.m2, n * (n - 1), out=np.full(beauty.m2.shape, np.nan), where=n > 1)
    bound = np.zeros(beauty.mean.shape) if film.bound is None else film.bound
    return of_picture(beauty.mean @ factors, np.sqrt(variance) @ factors, bound @ factors)


def of_reference(reference: Reference) -> list[Mean] | None:
    """None where its own error is not known: then it cannot tell noise from a fault."""
    if reference.variance is None:
        return None
    factors = weights(reference.mean.shape[-1])
    luminance = reference.mean @ factors
    return of_picture(luminance, np.sqrt(reference.variance) @ factors, np.zeros(luminance.shape))


def of_picture(luminance: Array, deviation: Array, bound: Array) -> list[Mean]:
    """deviation: at least the standard error of each pixel; each is (height, width)."""
    return [
        Mean(
            float(luminance[part].mean()),
            float(np.sqrt(np.sum(deviation[part] ** 2)) / luminance[part].size),
            float(bound[part].mean()),
        )
        for part in regions(*luminance.shape)
    ]


def regions(height: int, width: int) -> list[tuple[slice, slice]]:
    """Rows and columns of the whole, then of the parts, row by row."""
    rows, columns = (
        [slice(int(part[0]), int(part[-1]) + 1) for part in np.array_split(np.arange(size), min(PARTS, size))]
        for size in (height, width)
    )
    return [(slice(0, height), slice(0, width)), *((r, c) for r in rows for c in columns)]


def disagreeing(found: Sequence[Sequence[Mean]], truth: Sequence[Mean] | None = None) -> list[int]:
    """Which of the variants are not to be believed, by their number; all of them where no part is larger.

    Welch's test of every pair, or of each against the truth, at a level by Šidák (1967); the rounding that a
    certificate lets pass is no disagreement.
    """
    count = len(found)
    if truth is not None:
        limit = most_by_chance(count * len(truth))
        return [i for i in range(count) if _distance(found[i], truth) > limit]
    limit = most_by_chance(math.comb(count, 2) * len(found[0]))
    friends = [{j for j in range(count) if j == i or _distance(found[i], found[j]) <= limit} for i in range(count)]
    largest = max(friends, key=len)
    return [i for i in range(count) if i not in largest] if 2 * len(largest) > count else list(range(count))


def most_by_chance(tests: int) -> float:
    """Standard errors that a test may find by chance, at a level of FAMILY_WISE for all of them."""
    level = -math.expm1(math.log1p(-FAMILY_WISE) / max(tests, 1))
    return NormalDist().inv_cdf(1 - level / 2)


def _distance(a: Sequence[Mean], b: Sequence[Mean]) -> float:
    """The largest deviation of their means, in standard errors; those that are not known do not count."""
    return max((apart(x, y) for x, y in zip(a, b, strict=True)), default=0.0)


def apart(a: Mean, b: Mean) -> float:
    """How far apart they are, in standard errors; 0 where those are not known."""
    error = math.hypot(a.error, b.error)
    if not math.isfinite(error):
        return 0.0
    off = abs(a.value - b.value) - a.bound - b.bound - MOST_DRIFT * max(abs(a.value), abs(b.value))
    return 0.0 if off <= 0 else off / error if error > 0 else math.inf
