"""Transmittance by unbiased ray marching: Kettunen et al. (2021)."""

import itertools
import math
from collections.abc import Sequence

import numpy as np

from woodcock.space import Array

#: As in the device's file: of the elementary symmetric means.
ORDER = 7


def transmittance(optical_depth: Array) -> Array:
    """Float64 oracle: what the estimator's mean must be."""
    return np.asarray(np.exp(-optical_depth))


def points(depth: Array) -> Array:
    """Float64 oracle: points of a comb over so much optical depth of the majorant."""
    cube = (0.015 + depth) * (0.65 + depth) * (60.3 + depth)
    return np.maximum(np.floor(np.cbrt(cube) / 1.31945 + 0.5), 1)


def chance(order: int) -> float:
    """Float64 oracle: probability of this order of the series or a higher one."""
    return 1.0 if order == 0 else 0.1 if order < 3 else 0.1 * 2 ** (order - 1) / math.factorial(order)


def value(depths: Sequence[float]) -> float:
    """Float64 oracle: the estimate from the optical depths of all combs, straight from its definition."""
    first, order = depths[: ORDER + 1], len(depths) - 1
    total = 0.0
    for pivot in range(len(first)):
        others = [first[pivot] - depth for i, depth in enumerate(first) if i != pivot]
        for k in range(len(first)):
            products = [math.prod(chosen) for chosen in itertools.combinations(others, k)]
            total += math.exp(-first[pivot]) * float(np.mean(products)) / (math.factorial(k) * chance(k)) / len(first)
    for k in range(ORDER + 1, order + 1):
        product = math.prod(depths[0] - depth for depth in depths[1 : k + 1])
        total += math.exp(-depths[0]) * product / (math.factorial(k) * chance(k))
    return total
