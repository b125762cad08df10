"""Logarithmic axes: limits with some air, and ticks at round numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

#: Decades that an axis shows at least.
LEAST = 0.6
#: Multiples within a decade that ticks may stand at, from few to many.
STEPS = ((1,), (1, 3), (1, 2, 5), (1, 2, 3, 5, 7))


@dataclass(frozen=True)
class Axis:
    """Maps values from [low, high] to [start, stop] logarithmically."""

    low: float
    high: float
    start: float
    stop: float

    @classmethod
    def over(cls, values: Iterable[float], start: float, stop: float) -> Axis:
        """An axis that holds the values, which are positive."""
        logs = [math.log10(value) for value in values]
        span = max(logs) - min(logs)
        air = max(LEAST - span, 0) / 2 + 0.04 * max(span, LEAST)
        return cls(10 ** (min(logs) - air), 10 ** (max(logs) + air), start, stop)

    def at(self, value: float) -> float:
        share = math.log(value / self.low) / math.log(self.high / self.low)
        return self.start + share * (self.stop - self.start)

    def clipped(self, value: float) -> float:
        return self.at(min(max(value, self.low), self.high))

    def ticks(self, room: float) -> list[float]:
        """As many round numbers as there is room for, each taking so many units of the axis."""
        most = max(2, int(abs(self.stop - self.start) / room))
        decades = range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1)
        every = next(n for n in range(1, 1000) if len(decades) <= (most + 1) * n)
        found = self._inside(10.0**k for k in decades if k % every == 0)
        if every == 1:
            for steps in STEPS[1:]:
                more = self._inside(step * 10.0**k for k in decades for step in steps)
                # Unevenly spaced ticks need the room that the closest two have.
                closest = min((abs(self.at(b) - self.at(a)) for a, b in pairwise(more)), default=room)
                if len(more) <= most and closest >= 0.7 * room:
                    found = more
        return found

    def _inside(self, values: Iterable[float]) -> list[float]:
        return [value for value in values if self.low <= value <= self.high]
