"""Straight lines through correlated points: generalised least squares, with bands by Student's t."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from woodcock.space import Array


class Line(NamedTuple):
    """A fitted line. slope, error: its slope and the standard error of that; freedom: degrees of freedom of the error;
    scale: the points' covariance is scale² times the shape that was given.
    """

    slope: float
    error: float
    freedom: int
    scale: float


def fit(x: Array, y: Array, shape: Array) -> Line:
    """The line through points (x, y) whose errors in y have the covariance shape, up to a factor: Aitken (1936).

    The factor is that of the residuals, so that (slope - true slope) / error has Student's law where the errors are
    normal. It takes three points.
    """
    root = np.linalg.cholesky(shape)
    design = np.linalg.solve(root, np.stack([np.ones(len(x)), x - x.mean()], axis=1))
    target = np.linalg.solve(root, y)
    normal = design.T @ design
    found = np.linalg.solve(normal, design.T @ target)
    freedom = len(x) - 2
    scale = math.sqrt(float(np.sum((target - design @ found) ** 2)) / freedom)
    return Line(float(found[1]), scale * math.sqrt(float(np.linalg.inv(normal)[1, 1])), freedom, scale)


def quantile(level: float, freedom: int) -> float:
    """What |t| of Student's law exceeds with this probability."""
    low, high = 0.0, math.pi / 2
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if 1 - _within(middle, freedom) > level else (low, middle)
    return math.sqrt(freedom) * math.tan(low)


def _within(angle: float, freedom: int) -> float:
    """P(|t| < √freedom tan angle): Abramowitz & Stegun (1964), 26.7.3 and 26.7.4."""
    odd, cosine = freedom % 2, math.cos(angle)
    term, total = (cosine if odd else 1.0), 0.0
    for k in range(1 + odd, freedom, 2):
        total += term
        term *= cosine**2 * k / (k + 1)
    if odd:
        return 2 / math.pi * (angle + math.sin(angle) * total)
    return math.sin(angle) * total
