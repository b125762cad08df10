"""A bounding volume hierarchy: binned surface area heuristic (Wald, "On fast construction of SAH-based bounding volume
hierarchies", 2007), built a level at a time so that numpy does the work, laid out depth first with skip links.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from woodcock.space import Array

Integers = NDArray[np.int64]

BINS = 16
LARGEST_LEAF = 4
#: Levels after which boxes are halved by count, so that no arrangement of primitives makes a tree of many more.
SAH_LEVELS = 48
#: Boxes are padded by this part of the scene's largest coordinate: what rounding moves a ray at most.
PADDING = 2.0**-21


@dataclass(frozen=True)
class Hierarchy:
    """order: primitives as the leaves name them; boxes (n, 6) float32, lower and upper corners, outwards of the
    primitives; links (n, 2) int32: the box to go on with where this one is missed, and for a leaf 8 × its first
    primitive + how many, else -1."""

    order: Integers
    boxes: NDArray[np.float32]
    links: NDArray[np.int32]


@dataclass
class _Level:
    """Boxes of one level, each a run of `order`."""

    first: Integers
    count: Integers
    corners: Array  # (n, 2, 3)
    split: NDArray[np.bool_]  # those that have two children in the next level, in order


def build(bounds: Array) -> Hierarchy:
    """The hierarchy of primitives with `bounds` (n, 2, 3), n at least 1."""
    middles = bounds.mean(axis=1)
    order = np.arange(len(bounds))
    first, count = np.zeros(1, np.int64), np.array([len(bounds)])
    levels: list[_Level] = []
    while len(first):
        own = bounds[order[_members(first, count)]]
        split = count > LARGEST_LEAF
        levels.append(_Level(first, count, _joined(own, np.cumsum(count) - count), split))
        first, count = first[split], count[split]
        if not len(first):
            break
        at, starts = _members(first, count), np.cumsum(count) - count
        run = np.repeat(np.arange(len(first)), count)
        right = _goes_right(bounds[order[at]], middles[order[at]], run, starts, count, len(levels) >= SAH_LEVELS)
        # Each run in two, stably: what goes right comes after what does not.
        rank: Integers = np.cumsum(right) - right
        rank -= rank[starts][run]
        lefts = count - np.add.reduceat(right.astype(np.int64), starts)
        place = np.where(right, lefts[run] + rank, np.arange(len(run)) - starts[run] - rank)
        order[place + first[run]] = order[at]
        first = np.stack([first, first + lefts], axis=1).reshape(-1)
        count = np.stack([lefts, count - lefts], axis=1).reshape(-1)
    return _depth_first(order, levels)


def _members(first: Integers, count: Integers) -> Integers:
    """Positions in runs of `order`, one run after the other."""
    return np.asarray(np.arange(count.sum()) + np.repeat(first - (np.cumsum(count) - count), count))


def _joined(bounds: Array, starts: Integers) -> Array:
    """The bounds of runs of bounds."""
    return np.stack([np.minimum.reduceat(bounds[:, 0], starts), np.maximum.reduceat(bounds[:, 1], starts)], axis=1)


def _half_area(low: Array, high: Array) -> Array:
    x, y, z = np.moveaxis(high - low, -1, 0)
    return np.asarray(x * y + y * z + z * x)


def _goes_right(
    bounds: Array, middles: Array, run: Integers, starts: Integers, count: Integers, halve: bool
) -> NDArray[np.bool_]:
    """Which primitives of runs go to the right one of two boxes."""
    runs = len(count)
    low, high = np.minimum.reduceat(middles, starts), np.maximum.reduceat(middles, starts)
    axis = np.argmax(high - low, axis=1)
    every = np.arange(runs)
    width = (high - low)[every, axis]
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = np.where(width > 0, BINS / width, 0.0)
        part = (middles[np.arange(len(run)), axis[run]] - low[every, axis][run]) * scale[run]
    bin_of = np.clip(np.nan_to_num(part), 0, BINS - 1).astype(np.int64)
    key = run * BINS + bin_of

    counts = np.bincount(key, minlength=runs * BINS).reshape(runs, BINS)
    lows, highs = np.full((3, runs * BINS), np.inf), np.full((3, runs * BINS), -np.inf)
    for k in range(3):
        np.minimum.at(lows[k], key, bounds[:, 0, k])
        np.maximum.at(highs[k], key, bounds[:, 1, k])

    # Cost of every cut between bins: areas of what lies below and above it, times their primitives.
    below = np.cumsum(counts, axis=1)[:, :-1]
    above = count[:, None] - below
    low_of, high_of = (np.moveaxis(side.reshape(3, runs, BINS), 0, -1) for side in (lows, highs))
    left = _half_area(np.minimum.accumulate(low_of, 1)[:, :-1], np.maximum.accumulate(high_of, 1)[:, :-1])
    right = _half_area(
        np.minimum.accumulate(low_of[:, ::-1], 1)[:, -2::-1], np.maximum.accumulate(high_of[:, ::-1], 1)[:, -2::-1]
    )
    with np.errstate(invalid="ignore"):
        cost = np.where((below > 0) & (above > 0), left * below + right * above, np.inf)
    cut = np.argmin(cost, axis=1)
    to_the_right = bin_of > cut[run]
    # Where no cut separates anything, and in trees that grow too deep, runs are halved as they lie.
    halved = ~np.isfinite(cost[every, cut]) | halve
    position = np.arange(len(run)) - starts[run]
    return np.where(halved[run], position >= (count // 2)[run], to_the_right)


def _depth_first(order: Integers, levels: list[_Level]) -> Hierarchy:
    sizes: list[Integers] = [np.zeros(0, np.int64)] * len(levels)
    below = np.zeros(0, np.int64)
    for depth in reversed(range(len(levels))):
        size = np.ones(len(levels[depth].first), np.int64)
        size[levels[depth].split] += below.reshape(-1, 2).sum(axis=1)
        sizes[depth] = below = size
    total = int(sizes[0][0])
    boxes, links = np.empty((total, 6)), np.empty((total, 2), np.int64)
    place = np.zeros(1, np.int64)
    for depth, level in enumerate(levels):
        boxes[place] = level.corners.reshape(-1, 6)
        links[place, 0] = place + sizes[depth]
        links[place, 1] = np.where(level.split, -1, 8 * level.first + level.count)
        if depth + 1 < len(levels):
            left = place[level.split] + 1
            place = np.stack([left, left + sizes[depth + 1][::2]], axis=1).reshape(-1)
    pad = PADDING * np.abs(boxes).max()
    boxes[:, :3] -= pad
    boxes[:, 3:] += pad
    return Hierarchy(order, boxes.astype(np.float32), links.astype(np.int32))
