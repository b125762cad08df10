"""Henyey & Greenstein, "Diffuse radiation in the galaxy", ApJ 93, 1941."""

import numpy as np

from woodcock.scene import HenyeyGreensteinPhase
from woodcock.space import Array

FIELDS = {"g": "float", "gap": "float"}

#: Lobes beyond are taken as straight on; see `compose.delta_fraction`.
NARROWEST = 0.9999


def lobe(g: float) -> tuple[float, float]:
    """g and 1 - |g| as device code takes them, |g| at most NARROWEST."""
    bounded = max(-NARROWEST, min(g, NARROWEST))
    return bounded, 1 - abs(bounded)


def record(phase: HenyeyGreensteinPhase) -> dict[str, float]:
    return dict(zip(FIELDS, lobe(phase.g), strict=True))


def evaluate(phase: HenyeyGreensteinPhase, cosine: Array) -> Array:
    """Float64 oracle: p(cos θ), per steradian."""
    g = phase.g
    return np.asarray((1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * cosine) ** 1.5))


def mean_cosine(phase: HenyeyGreensteinPhase) -> float:
    return phase.g


def cumulative(phase: HenyeyGreensteinPhase, cosine: Array) -> Array:
    """Probability that a sample's cosine lies below: the textbook integral, with its limit for g = 0."""
    g = phase.g
    if abs(g) < 1e-9:
        return np.asarray((1 + cosine) / 2)
    return np.asarray((1 - g * g) / (2 * g) * (1 / np.sqrt(1 + g * g - 2 * g * cosine) - 1 / (1 + g)))
