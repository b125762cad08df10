"""How many samples to ask of a device at a time. Pure: whoever drives a render measures and asks."""

from __future__ import annotations

from dataclasses import dataclass

#: Seconds that a range should take: long beside the cost of handing it out, short beside what a crash may lose.
RANGE_SECONDS = 1.0
#: A first measurement is noisy, so ranges grow by this factor at most.
GROWTH = 8


@dataclass
class Pace:
    """How fast a device renders a scene; rate in paths (samples × pixels) per second, 0 until it is known.

    last: samples of the last range. A device that is not full takes no less time for fewer pixels, but no more either:
    so it is samples, not paths, by which ranges must not grow too fast.
    """

    rate: float = 0.0
    last: int = 0

    def measured(self, samples: int, seconds: float, pixels: int = 1) -> None:
        """pixels: that the range was of; a driver that never leaves any out may count all of them as one."""
        self.rate = samples * pixels / max(seconds, 1e-6)
        self.last = samples

    def size(self, seconds: float, pixels: int = 1) -> int:
        """Samples of so many pixels for so many seconds; 1 as long as the rate is not known."""
        return max(1, min(int(self.rate * seconds / pixels), GROWTH * self.last))


def fit(pace: Pace, seconds: float, nothing_yet: bool, pixels: int = 1, longest: float = RANGE_SECONDS) -> int:
    """How many samples of so many pixels fit into the seconds that are left; 0 when it is time to stop.

    longest: seconds that a range should take.

    Counts and times of past ranges decide, never what a running range does: to drop the slow ones would be a bias.
    """
    if nothing_yet or (pace.rate == 0 and seconds > 0):
        return 1
    if seconds <= 0 or pace.rate * seconds / pixels < 0.5:
        return 0
    return pace.size(min(seconds, longest), pixels)
