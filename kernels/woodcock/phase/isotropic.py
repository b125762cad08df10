"""Isotropic scattering."""

import numpy as np

from woodcock.scene import IsotropicPhase
from woodcock.space import Array

# A struct needs a member; the compiler drops it.
FIELDS = {"unused": "int"}


def record(phase: IsotropicPhase) -> dict[str, int]:
    return {"unused": 0}


def evaluate(phase: IsotropicPhase, cosine: Array) -> Array:
    """Float64 oracle: p(cos θ), per steradian."""
    return np.full_like(cosine, 1 / (4 * np.pi))


def mean_cosine(phase: IsotropicPhase) -> float:
    return 0.0


def cumulative(phase: IsotropicPhase, cosine: Array) -> Array:
    """Probability that a sample's cosine lies below."""
    return np.asarray((1 + cosine) / 2)
