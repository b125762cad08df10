"""Blocks of cells under one bound, which walks through a majorant's grid cross at once (grid_hops.h)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from woodcock.space import Array

#: In tentative collisions: what a cell costs that a ray crosses, and what a block does. Timed on a cloud at five
#: densities, smoke, fire, and a dense core in haze (`woodcock compare --vary majorant=global,grid`).
CROSSING, HOPPING = 0.1, 0.16
#: A block has 2^n - 1 cells to every side of its middle one, with n up to this: what three bits hold.
MOST = 7


class Hops(NamedTuple):
    """Of every cell, [z][y][x]: bounds, the largest of its block; exponents, n of the block. cost: of a ray, in the
    mean over cells, as that of `crossing`."""

    bounds: Array
    exponents: NDArray[np.uint32]
    cost: float


def pace(sides: Array, cells: Sequence[int]) -> float:
    """How far rays get from one face of cells to the next, in the mean. sides: (3,) of the box that is cut."""
    return 1 / float(np.sum(np.array(cells) / sides))


def crossing(bounds: Array, pace: float) -> float:
    """What it costs to get from one face of cells to the next, cell by cell, in tentative collisions."""
    return float(bounds.mean()) * pace + CROSSING


def hops(bounds: Array, pace: float) -> Hops:
    """Blocks as large as pay. bounds: [z][y][x], 1 / length of `pace`."""
    largest = total = bounds
    count = np.ones_like(total)
    found, exponents = bounds.copy(), np.zeros(bounds.shape, np.uint32)
    cost = np.full(bounds.shape, HOPPING)
    for exponent in range(1, MOST + 1):
        step = 1 << (exponent - 1)
        if step >= max(bounds.shape):
            break
        largest = _widened(largest, step, np.maximum)
        total, count = _widened(total, step, np.add), _widened(count, step, np.add)
        # What other cells lift this block's bound by costs tentative collisions for nothing.
        own = np.maximum(largest - total / count, 0) * pace + HOPPING / (1 << exponent)
        better = own < cost
        if not better.any():
            break
        found[better], exponents[better], cost[better] = largest[better], exponent, own[better]
    return Hops(found, exponents, float(bounds.mean()) * pace + float(cost.mean()))


def _widened(values: Array, step: int, combine: Callable[..., object]) -> Array:
    """Of what lies `step` cells to each side along every axis, and in the middle."""
    for axis in range(3):
        line = np.moveaxis(values, axis, 0)
        wider = line.copy()
        combine(wider[step:], line[:-step], out=wider[step:])
        combine(wider[:-step], line[step:], out=wider[:-step])
        values = np.moveaxis(wider, 0, axis)
    return values
