"""The mean over a square."""

import numpy as np

from woodcock.scene import BoxFilter
from woodcock.space import Array

FIELDS = {"radius": "float"}


def record(box: BoxFilter) -> dict[str, float]:
    return {"radius": box.radius}


def density(box: BoxFilter, offset: Array) -> Array:
    """Float64 oracle: per pixel, along one axis."""
    return np.where(np.abs(offset) <= box.radius, 1 / (2 * box.radius), 0.0)


def cumulative(box: BoxFilter, offset: Array) -> Array:
    """Float64 oracle: probability that a sample's offset lies below."""
    return np.clip(0.5 + offset / (2 * box.radius), 0, 1)
