"""Which samples to hand out next, and how many to whom. Pure; the dispatcher's decisions without its machinery."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

Range: TypeAlias = tuple[int, int]

#: Seconds that a range should take: long beside the cost of handing it out, short beside what a crash may lose.
RANGE_SECONDS = 1.0
#: A range of less than this is not worth handing out, unless it is what is left.
LEAST_SECONDS = 0.1
#: A first measurement is noisy, so ranges grow by this factor at most.
GROWTH = 8


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


@dataclass
class Pace:
    """How fast a device renders a scene; rate in samples per second, 0 until it is known."""

    rate: float = 0.0
    last: int = 0

    def measured(self, samples: int, seconds: float) -> None:
        self.rate = samples / max(seconds, 1e-6)
        self.last = samples

    def size(self, seconds: float) -> int:
        """Samples for so many seconds; 1 as long as the rate is not known."""
        return max(1, min(int(self.rate * seconds), GROWTH * self.last))


def share(pace: Pace, left: int, total_rate: float) -> int:
    """How many of the samples that are left this device should render next, so that all devices end together."""
    fair = math.ceil(left * pace.rate / total_rate) if total_rate > 0 else left
    return min(left, pace.size(RANGE_SECONDS), max(fair, pace.size(LEAST_SECONDS)))


def fit(pace: Pace, seconds: float, nothing_yet: bool) -> int:
    """How many samples fit into the seconds that are left; 0 when it is time to stop.

    Counts and times of past ranges decide, never what a running range does: to drop the slow ones would be a bias.
    """
    if nothing_yet or (pace.rate == 0 and seconds > 0):
        return 1
    if seconds <= 0 or pace.rate * seconds < 0.5:
        return 0
    return pace.size(min(seconds, RANGE_SECONDS))
