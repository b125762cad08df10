"""Which samples to hand out next, and how many to whom. Pure; the dispatcher's decisions without its machinery."""

from __future__ import annotations

import math
from typing import TypeAlias

from woodcock.pace import RANGE_SECONDS, Pace

Range: TypeAlias = tuple[int, int]

#: A range of less than this is not worth handing out, unless it is what is left.
LEAST_SECONDS = 0.1


class Pool:
    """The samples of [0, end) that no film holds and nobody renders. Each is handed out once."""

    def __init__(self, done: tuple[Range, ...], end: int) -> None:
        self._free: list[Range] = []
        start = 0
        for first, stop in (*sorted(done), (end, end)):
            if start < first:
                self._free.append((start, min(first, end)))
            start = max(start, stop)

    @property
    def left(self) -> int:
        return sum(stop - start for start, stop in self._free)

    def take(self, count: int) -> Range:
        """The next samples, up to `count` of them, 1 at least. Raises IndexError when none is left."""
        start, stop = self._free.pop(0)
        middle = min(stop, start + max(1, count))
        if middle < stop:
            self._free.insert(0, (middle, stop))
        return start, middle


def share(pace: Pace, left: int, total_rate: float) -> int:
    """How many of the samples that are left this device should render next, so that all devices end together."""
    fair = math.ceil(left * pace.rate / total_rate) if total_rate > 0 else left
    return min(left, pace.size(RANGE_SECONDS), max(fair, pace.size(LEAST_SECONDS)))
