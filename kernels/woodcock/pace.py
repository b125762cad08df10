"""How many samples to ask of a device at a time. Pure: whoever drives a render measures and asks."""

from __future__ import annotations

from dataclasses import dataclass

#: Seconds that a range should take: long beside the cost of handing it out, short beside what a crash may lose.
RANGE_SECONDS = 1.0
#: A first measurement is noisy, so ranges grow by this factor at most.
GROWTH = 8


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


def fit(pace: Pace, seconds: float, nothing_yet: bool) -> int:
    """How many samples fit into the seconds that are left; 0 when it is time to stop.

    Counts and times of past ranges decide, never what a running range does: to drop the slow ones would be a bias.
    """
    if nothing_yet or (pace.rate == 0 and seconds > 0):
        return 1
    if seconds <= 0 or pace.rate * seconds < 0.5:
        return 0
    return pace.size(min(seconds, RANGE_SECONDS))
