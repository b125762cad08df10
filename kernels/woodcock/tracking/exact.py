"""Transmittance of a homogeneous medium."""

import numpy as np

from woodcock.space import Array


def transmittance(optical_depth: Array) -> Array:
    """Float64 oracle: Beer & Lambert."""
    return np.asarray(np.exp(-optical_depth))
