"""Rayleigh scattering without depolarisation: p = 3 (1 + cos² θ) / 16π."""

import numpy as np

from woodcock.scene import RayleighPhase
from woodcock.space import Array

# A struct needs a member; the compiler drops it.
FIELDS = {"unused": "int"}


def record(phase: RayleighPhase) -> dict[str, int]:
    return {"unused": 0}


def evaluate(phase: RayleighPhase, cosine: Array) -> Array:
    """Float64 oracle: p(cos θ), per steradian."""
    return np.asarray(3 / (16 * np.pi) * (1 + cosine**2))


def mean_cosine(phase: RayleighPhase) -> float:
    return 0.0


def cumulative(phase: RayleighPhase, cosine: Array) -> Array:
    """Probability that a sample's cosine lies below."""
    return np.asarray((cosine**3 + 3 * cosine + 4) / 8)
