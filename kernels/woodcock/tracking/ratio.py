"""Transmittance by ratio tracking: Cramer (1978), Novák et al. (2014)."""

import numpy as np

from woodcock.space import Array


def transmittance(optical_depth: Array) -> Array:
    """Float64 oracle: what the estimator's mean must be."""
    return np.asarray(np.exp(-optical_depth))
