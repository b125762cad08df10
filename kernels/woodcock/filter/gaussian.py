"""A Gaussian, cut off at four standard deviations."""

import math

import numpy as np

from woodcock.scene import GaussianFilter
from woodcock.space import Array

FIELDS = {"deviation": "float"}

CUT = 4.0
#: What of the Gaussian is kept.
KEPT = math.erf(CUT / math.sqrt(2))


def record(gaussian: GaussianFilter) -> dict[str, float]:
    return {"deviation": gaussian.deviation}


def density(gaussian: GaussianFilter, offset: Array) -> Array:
    """Float64 oracle: per pixel, along one axis."""
    x = offset / gaussian.deviation
    peak = 1 / (math.sqrt(2 * math.pi) * gaussian.deviation * KEPT)
    return np.where(np.abs(x) <= CUT, peak * np.exp(-x * x / 2), 0.0)


def cumulative(gaussian: GaussianFilter, offset: Array) -> Array:
    """Float64 oracle: probability that a sample's offset lies below."""
    x = np.clip(offset / gaussian.deviation, -CUT, CUT) / math.sqrt(2)
    return np.asarray(0.5 + np.vectorize(math.erf)(x) / (2 * KEPT))
