"""Transmittance by residual ratio tracking: Novák et al. (2014)."""

import numpy as np

from woodcock.space import Array


def transmittance(optical_depth: Array) -> Array:
    """Float64 oracle: what the estimator's mean must be."""
    return np.asarray(np.exp(-optical_depth))


def variance(optical_depth: Array, squares: Array) -> Array:
    """Float64 oracle: of a walk that is not cut; squares: ∫ (σ_t - control)² / bound. Ratio tracking has no control."""
    return np.asarray(np.exp(-2 * optical_depth) * np.expm1(squares))
