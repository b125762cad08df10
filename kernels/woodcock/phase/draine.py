"""Draine, "Scattering by interstellar dust grains", ApJ 598, 2003: Henyey–Greenstein × (1 + α cos² θ) / N."""

import numpy as np

from woodcock.phase import henyey_greenstein
from woodcock.scene import DrainePhase, HenyeyGreensteinPhase
from woodcock.space import Array

FIELDS = {"g": "float", "gap": "float", "base": "float", "square": "float"}


def norm(phase: DrainePhase) -> float:
    """N, the mean of 1 + α cos² θ under Henyey & Greenstein."""
    return 1 + phase.alpha * (1 + 2 * phase.g**2) / 3


def record(phase: DrainePhase) -> dict[str, float]:
    values = (phase.g, 1 - abs(phase.g), 1 / norm(phase), phase.alpha / norm(phase))
    return dict(zip(FIELDS, values, strict=True))


def evaluate(phase: DrainePhase, cosine: Array) -> Array:
    """Float64 oracle: p(cos θ), per steradian."""
    lobe = henyey_greenstein.evaluate(HenyeyGreensteinPhase(g=phase.g), cosine)
    return lobe * ((1 + phase.alpha * cosine**2) / norm(phase))


def mean_cosine(phase: DrainePhase) -> float:
    """Not g, but for α = 0."""
    return phase.g * (1 + phase.alpha * (3 + 2 * phase.g**2) / 5) / norm(phase)


def cumulative(phase: DrainePhase, cosine: Array) -> Array:
    """Probability that a sample's cosine lies below.

    The integral in t = √(1 + g² - 2 g cos θ), which cancels by g³; quadrature where that would cost digits.
    """
    g, alpha = phase.g, phase.alpha
    cosine = np.asarray(cosine, float)
    if abs(g) < 0.1:
        nodes, weights = np.polynomial.legendre.leggauss(32)
        half = (cosine[..., None] + 1) / 2
        return np.asarray(2 * np.pi * (evaluate(phase, half * (nodes + 1) - 1) * weights * half).sum(axis=-1))

    def integral(t: Array | float) -> Array | float:
        a = 1 + g * g
        return -1 / t + alpha / (4 * g * g) * (-a * a / t - 2 * a * t + t**3 / 3)

    t = np.sqrt(1 + g * g - 2 * g * cosine)
    return np.asarray((1 - g * g) / (2 * norm(phase) * g) * (integral(1 + g) - integral(t)))
