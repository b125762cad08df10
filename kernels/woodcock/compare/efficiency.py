"""Efficiency = 1 / (variance × time) of a render in slices, and how far a ratio of two is known.

A slice is a part of a render with samples of its own: so many seconds, samples per pixel, and the variance of one
sample. Rendered in turns (A B C A B C …), slices of one round share the machine's mood, and pairs of them tell what
the variants differ in.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypedDict

import numpy as np

from woodcock.regression import quantile
from woodcock.space import Array

#: Probability that an interval misses.
LEVEL = 0.05


class Slice(NamedTuple):
    """seconds: of rendering; samples: per pixel; variance: of a pixel's sample, its channels weighted by luminance,
    mean over the pixels."""

    seconds: float
    samples: float
    variance: float


class Ratio(TypedDict):
    """low, high: the 95 % interval; None where there are too few slices to tell."""

    value: float
    low: float | None
    high: float | None


def efficiency(slices: Sequence[Slice]) -> float | None:
    """1 / (variance of a pixel's mean × seconds); None where no slice has two samples, or nothing varies."""
    value = math.exp(_logs(np.array(slices))) if slices else math.nan
    return value if math.isfinite(value) else None


def ratio(a: Sequence[Slice], b: Sequence[Slice]) -> Ratio | None:
    """How many times as efficient as b a is; None where that of one is not known.

    The interval is Student's, by the jackknife of the logarithm (Tukey 1958): over pairs of slices where both have as
    many, over the slices of each where not (Welch 1947).
    """
    mine, its = np.array(a), np.array(b)
    if efficiency(a) is None or efficiency(b) is None:
        return None
    log = _logs(mine) - _logs(its)
    if len(mine) == len(its):
        variance, freedom = _jackknife(_left_out(mine) - _left_out(its))
    else:
        (v, n), (w, m) = _jackknife(_left_out(mine)), _jackknife(_left_out(its))
        variance = v + w
        freedom = variance**2 / (v**2 / n + w**2 / m) if n and m and variance else 0.0
    if freedom < 1 or not math.isfinite(variance):
        return {"value": math.exp(log), "low": None, "high": None}
    half = quantile(LEVEL, math.floor(freedom)) * math.sqrt(variance)
    return {"value": math.exp(log), "low": math.exp(log - half), "high": math.exp(log + half)}


def of_series(points: Sequence[Mapping[str, Any]]) -> list[Slice]:
    """The slices between the points of an error series, each of all samples so far.

    For renders that kept no slices: what is between two points has n₂ - n₁ samples, and the M2 that came with them.
    Time is the devices'.
    """
    slices, before = list[Slice](), (0.0, 0.0, 0.0)
    for point in points:
        seconds, samples, rmse = (float(point[key]) for key in ("device_seconds", "samples", "rmse"))
        squares = rmse**2 * samples * (samples - 1)
        added = samples - before[1]
        if added >= 2:
            slices.append(Slice(seconds - before[0], added, max(0.0, squares - before[2]) / (added - (before[1] == 0))))
            before = (seconds, samples, squares)
    return slices


def _logs(slices: Array) -> float:
    """log efficiency: slices' variances are pooled by their degrees of freedom."""
    seconds, samples, variance = slices.T
    freedom = np.maximum(samples - 1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        pooled = np.sum(freedom * np.where(freedom > 0, variance, 0.0)) / np.sum(freedom)
        return float(np.log(np.sum(samples)) - np.log(np.sum(seconds)) - np.log(pooled))


def _left_out(slices: Array) -> Array:
    """log efficiency without one slice, each in turn."""
    return np.array([_logs(np.delete(slices, index, axis=0)) for index in range(len(slices))])


def _jackknife(left_out: Array) -> tuple[float, float]:
    """Variance, and its degrees of freedom."""
    count = len(left_out)
    if count < 2:
        return math.nan, 0.0
    if not np.isfinite(left_out).all():
        return math.nan, 0.0
    return float((count - 1) / count * np.sum((left_out - left_out.mean()) ** 2)), count - 1.0
