"""Which samples to hand out next, and how many to whom. Pure; the dispatcher's decisions without its machinery."""

from __future__ import annotations

import math
from collections.abc import Iterable

from woodcock.contract import Piece
from woodcock.pace import RANGE_SECONDS, Pace

#: A range of less than this is not worth handing out, unless it is what is left.
LEAST_SECONDS = 0.1
#: A device that is lost may cost as much, or a quarter of what it may take before it is killed.
LONGEST_SECONDS = 60.0
#: What a range costs the dispatcher, as measured ("How large" in README): seconds, and in parts of what merging its
#: film takes. The film comes over TLS, which takes half again as long.
HANDING_SECONDS, FILM = 0.006, 2.5
#: For how much of its time the dispatcher may be busy with that.
BUSY = 0.5


class Pool:
    """The pieces of a round that nobody renders yet. Every sample is handed out once, or again when it was put back."""

    def __init__(self, pieces: Iterable[Piece], pixels: int) -> None:
        """pixels: of the whole picture, which pieces without a list of pixels are of."""
        self._free, self._whole = list(pieces), pixels

    def put_back(self, pieces: Iterable[Piece]) -> None:
        """Pieces that nobody will render after all."""
        self._free[:0] = pieces

    @property
    def left(self) -> int:
        """Paths (samples × pixels) that nobody has taken."""
        return sum((piece.stop - piece.start) * piece.width(self._whole) for piece in self._free)

    @property
    def pixels(self) -> int:
        """Of the piece that comes next; 0 when none is left."""
        return self._free[0].width(self._whole) if self._free else 0

    def take(self, count: int) -> Piece:
        """The next samples, up to `count` of them, 1 at least. Raises IndexError when none is left."""
        piece, rest = self._free.pop(0).cut(count)
        self._free[:0] = rest
        return piece


def turn_of(devices: int, merging: float) -> float:
    """Seconds that the dispatcher, which serves one device after the other, takes for a range of each.

    merging: seconds that merging a film takes.
    """
    return devices * (HANDING_SECONDS + FILM * merging)


def length(turn: float, longest: float = LONGEST_SECONDS) -> float:
    """How long a range should take, seconds: one, or as long as leaves the dispatcher time."""
    return max(RANGE_SECONDS, min(turn / BUSY, longest))


def share(pace: Pace, pool: Pool, total_rate: float, seconds: float = RANGE_SECONDS, turn: float = 0.0) -> int:
    """How many samples of the pool's next pixels this device should render, so that all devices end together.

    pool: not empty; total_rate: of all devices, paths per second; seconds: that it should take; turn: in which the
    dispatcher serves all devices once, so that they would wait for it with less.
    """
    fair = math.ceil(pool.left * pace.rate / (total_rate * pool.pixels)) if total_rate > 0 else 1
    return min(pace.size(seconds, pool.pixels), max(fair, pace.size(max(LEAST_SECONDS, turn), pool.pixels)))
