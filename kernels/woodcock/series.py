"""Error against run time: the points of a render's error series, and when to take them; `convergence` fits them.

Pure: whoever drives a render asks whether a point is due, and measures. Without noise nothing falls, and is no series.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypedDict

import numpy as np

from woodcock import metrics
from woodcock.convergence import Slope as Slope
from woodcock.convergence import slope as slope
from woodcock.film import Film
from woodcock.reference import Reference
from woodcock.space import Array

#: Samples from one point of the error series to the next.
SERIES_GROWTH = math.sqrt(2)
#: FLIP belongs to a point if it should take less than this share of the time so far. Points are so far apart that all
#: of them together take less than a tenth of it.
FLIP_SHARE = 1 / 20


class Against(TypedDict):
    """A picture against a reference, as `metrics` has it.

    reference_mse: the mean variance of the reference's pixels, which was subtracted from mse, and its like from
    rel_mse; None where it is not known: then the reference counts as exact. bias_error: None where the picture's noise
    is not known. flip: None where it was not computed.
    """

    mse: float
    rel_mse: float
    smape: float
    bias: float
    bias_error: float | None
    flip: float | None
    reference_mse: float | None


class Point(TypedDict):
    """A point of the error series. seconds: wall, since the render began; device_seconds: of rendering, of all devices;
    samples: per pixel, on average. rmse, rel_mse: by the samples' own variances: `Film.rmse`, `estimated_rel_mse`.
    """

    seconds: float
    device_seconds: float
    samples: float
    rmse: float
    rel_mse: float
    against: Against | None


def due(series: Sequence[Point], film: Film) -> bool:
    """Is it time for the next point? They are geometric in samples."""
    return not series or film.mean_samples >= series[-1]["samples"] * SERIES_GROWTH


def measure(film: Film, seconds: float, device_seconds: float, reference: Reference | None) -> Point | None:
    """The error after so many seconds; None while it cannot be estimated, with fewer than two samples of a pixel.

    Without noise too: there is one error then, and nothing that falls. FLIP is computed where there is time for it.
    """
    rmse = math.nan if film.deterministic else film.rmse()
    if not math.isfinite(rmse):
        return None
    beauty = film.layer("")
    return {
        "seconds": seconds,
        "device_seconds": device_seconds,
        "samples": film.mean_samples,
        "rmse": rmse,
        "rel_mse": metrics.estimated_rel_mse(beauty.mean, beauty.variance()),
        "against": None if reference is None else against(film, reference, FLIP_SHARE * seconds),
    }


def against(film: Film, reference: Reference, flip_within: float = math.inf) -> Against:
    """A film's beauty against a reference of its size. flip_within: seconds that there are for FLIP.

    Where one of them is grey it counts as three equal channels.
    """
    beauty = film.layer("")
    shape = np.broadcast_shapes(beauty.mean.shape, reference.mean.shape)
    mean, variance, truth = (np.broadcast_to(one, shape) for one in (beauty.mean, beauty.variance(), reference.mean))
    its = None if reference.variance is None else np.broadcast_to(reference.variance, shape)
    return held_against(mean, variance, truth, its, flip_within)


def held_against(
    mean: Array, variance: Array | None, truth: Array, its: Array | None, flip_within: float = math.inf
) -> Against:
    """A picture and its variance against a reference and its own, all of one shape; None: not known."""
    error = math.nan if variance is None else metrics.bias_error(variance, *([] if its is None else [its]))
    return {
        "mse": metrics.mse(mean, truth, its),
        "rel_mse": metrics.rel_mse(mean, truth, its),
        "smape": metrics.smape(mean, truth),
        "bias": metrics.bias(mean, truth),
        "bias_error": error if math.isfinite(error) else None,
        "flip": metrics.flip(mean, truth) if metrics.flip_seconds(truth) < flip_within else None,
        "reference_mse": None if its is None else metrics.noise(its),
    }


def efficiency(film: Film, seconds: float) -> float | None:
    """1 / (mean variance of a pixel × seconds), 1 / (radiance² s); None where the variance is 0 or not known."""
    square = math.nan if film.deterministic else film.rmse() ** 2
    return 1 / (square * seconds) if math.isfinite(square) and square * seconds > 0 else None
