"""How a farm of any size would do, by what its parts were measured to take: a simulation of ranges, films and merges.

Devices render ranges of a fixed time, each with one range waiting. Their films go to the dispatcher, or by a tree of
workers that merge as many films into one; each of these, and the dispatcher, takes them one after the other.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Costs:
    """Seconds. handing: of the dispatcher for each range it hands out and hears of; merging: for each film that is
    merged, wherever."""

    range: float
    handing: float
    merging: float


def efficiency(devices: int, ranges: int, costs: Costs, fan_in: int = 1) -> float:
    """Device time of so many ranges each, over what they took. fan_in: films that a worker merges into one before they
    go on, and devices that it hands ranges to, at every level of the tree; 1 for none."""
    ends = [(costs.range, device, 1) for device in range(devices)]
    heapq.heapify(ends)
    free = [0.0]  # the dispatcher, first; then the merging workers of the tree's levels, by their number
    levels = list(_levels(devices, fan_in))
    free += [0.0] * sum(levels)
    ended = 0.0
    while ends:
        now, device, count = heapq.heappop(ends)
        ended = max(ended, now)
        place, first = device, 1
        arrived = now
        for level, width in enumerate(levels):
            place //= fan_in
            # Of so many films below one comes up: each counts for its share of that.
            merging = costs.merging / fan_in**level
            arrived = free[first + place] = max(arrived, free[first + place]) + merging
            first += width
        # Of what a tree has merged the dispatcher has one film in the place of all.
        share = fan_in ** len(levels)
        free[0] = max(arrived, free[0]) + costs.handing / share + costs.merging / share
        ended = max(ended, free[0])
        if count < ranges:
            # One range waits at the device: it goes on at once, unless the dispatcher is a whole range behind.
            heapq.heappush(ends, (max(now, free[0] - costs.range) + costs.range, device, count + 1))
    return ranges * costs.range / ended


def _levels(devices: int, fan_in: int) -> Iterator[int]:
    """Merging workers at each level, from the devices up, until one level would be as good as the dispatcher."""
    width = devices
    while fan_in > 1 and width > fan_in:
        width = -(-width // fan_in)
        yield width
