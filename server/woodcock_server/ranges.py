"""Which samples to hand out next, and how many to whom. Pure; the dispatcher's decisions without its machinery."""

from __future__ import annotations

import math
from collections.abc import Iterable

from woodcock.contract import Piece
from woodcock.pace import RANGE_SECONDS, Pace

#: A range of less than this is not worth handing out, unless it is what is left.
LEAST_SECONDS = 0.1


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


def share(pace: Pace, pool: Pool, total_rate: float) -> int:
    """How many samples of the pool's next pixels this device should render, so that all devices end together.

    pool: not empty; total_rate: of all devices, paths per second.
    """
    fair = math.ceil(pool.left * pace.rate / (total_rate * pool.pixels)) if total_rate > 0 else 1
    return min(pace.size(RANGE_SECONDS, pool.pixels), max(fair, pace.size(LEAST_SECONDS, pool.pixels)))
