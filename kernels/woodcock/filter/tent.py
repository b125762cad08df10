"""Falls linearly from the pixel's middle."""

import numpy as np

from woodcock.scene import TentFilter
from woodcock.space import Array

FIELDS = {"radius": "float"}


def record(tent: TentFilter) -> dict[str, float]:
    return {"radius": tent.radius}


def density(tent: TentFilter, offset: Array) -> Array:
    """Float64 oracle: per pixel, along one axis."""
    return np.asarray(np.maximum(1 - np.abs(offset) / tent.radius, 0) / tent.radius)


def cumulative(tent: TentFilter, offset: Array) -> Array:
    """Float64 oracle: probability that a sample's offset lies below."""
    x = np.clip(offset / tent.radius, -1, 1)
    return np.asarray(0.5 + x - x * np.abs(x) / 2)
