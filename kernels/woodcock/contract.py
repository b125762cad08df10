"""What to render next until a scene's contract is met, and whether it was. Pure: a function of the film alone.

Contracts of a relative error are met by rounds. The first, the pilot, is of all pixels; the others are of those pixels
that still need samples, as `judging.py` finds. A round's pixels need different numbers of samples, in few steps. Its
pieces are those steps: each of new samples, of the pixels that need them, so that no sample index has two meanings.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from woodcock.batches import TILE, tiles
from woodcock.film import Film, weights
from woodcock.judging import needed
from woodcock.scene import RelativeErrorStop, SamplesStop, SecondsStop, Stop
from woodcock.space import Array

#: Samples of a pixel that can be addressed.
MOST_SAMPLES = 1 << 31

#: Samples of every pixel that the first decision is made by. The 256 judges of a tile then know its variance to
#: √(κ / 8192) of it, where κ is the kurtosis of a sample: to a tenth even for κ = 80. What is black costs no more.
PILOT = 32

#: Numbers of samples of a round grow by this factor: few launches, and a tenth more samples than are needed, about.
STEP = 2**0.25


@dataclass(frozen=True)
class Piece:
    """Samples [start, stop) of pixels, given by their indices y × width + x; None for all of them."""

    start: int
    stop: int
    pixels: NDArray[np.int32] | None

    def width(self, everything: int) -> int:
        """How many pixels, of a picture of so many."""
        return everything if self.pixels is None else int(self.pixels.size)

    def cut(self, count: int) -> tuple[Piece, list[Piece]]:
        """Its first samples, up to `count` of them, 1 at least; and what is left, if anything."""
        middle = min(self.stop, self.start + max(1, count))
        rest = [Piece(middle, self.stop, self.pixels)] if middle < self.stop else []
        return Piece(self.start, middle, self.pixels), rest


class Contract(TypedDict):
    """What was asked for (samples, seconds or relative error) and what was reached; None where it is not known."""

    kind: str
    asked: float
    reached: float | None
    met: bool
    says: str


def next_round(stop: Stop, film: Film | None) -> list[Piece]:
    """What to render next; nothing once the contract is met, or where more samples would not help.

    The pieces of a round are disjoint in samples, and its decision is made of everything before it: all of them belong
    into the film that the next round is asked for by. A film whose last round was cut short will do as well. A contract
    of seconds has one endless piece: its end is the driver's to see.
    """
    if not isinstance(stop, RelativeErrorStop):
        return _missing(film, stop.samples if isinstance(stop, SamplesStop) else MOST_SAMPLES)
    pilot = _missing(film, PILOT)
    if film is None or pilot:
        return pilot
    return [] if film.deterministic else _steps(film, needed(stop, film))


def _missing(film: Film | None, end: int) -> list[Piece]:
    """The samples of [0, end) that a film does not hold, of all pixels."""
    pieces, start = [], 0
    for first, stop in (*(film.ranges if film else ()), (end, end)):
        if start < min(first, end):
            pieces.append(Piece(start, min(first, end), None))
        start = max(start, stop)
    return pieces


def _steps(film: Film, needed: Array) -> list[Piece]:
    """Pieces that bring every pixel to at least the samples that it needs, by steps; needed: (height, width)."""
    start = film.ranges[-1][1]
    missing = np.clip(needed - film.count, 0, MOST_SAMPLES - start).reshape(-1)
    steps = np.ceil(np.log(np.maximum(missing, 1)) / math.log(STEP))
    more = np.where(missing > 0, np.ceil(STEP**steps), 0).astype(np.int64)
    more = np.minimum(more, MOST_SAMPLES - start)
    pieces, last = [], 0
    for samples in np.unique(more[more > 0]).tolist():
        pixels = np.flatnonzero(more >= samples).astype(np.int32)
        pieces.append(Piece(start + last, start + samples, pixels if pixels.size < more.size else None))
        last = samples
    return pieces


def outcome(stop: Stop, film: Film, seconds: float) -> Contract:
    """Whether the contract is met by a film that took so many seconds of rendering."""
    if isinstance(stop, SamplesStop):
        met = film.samples >= stop.samples
        says = f"{film.samples} of {stop.samples} samples of every pixel."
        return {"kind": stop.kind, "asked": stop.samples, "reached": film.samples, "met": met, "says": says}
    if isinstance(stop, SecondsStop):
        says = f"{film.samples} samples of every pixel in {seconds:.3g} s of {stop.seconds:.3g} s."
        met = film.samples > 0
        return {"kind": stop.kind, "asked": stop.seconds, "reached": seconds, "met": met, "says": says}
    reached, asked = relative_error(stop, film), stop.relative_error
    error = "bound on its error" if film.deterministic else "standard error of a pixel"
    where = "of the worst tile" if stop.per == "tile" else "of the picture"
    says = "The error is not known."
    met = reached is not None and reached <= asked
    if reached is not None:
        says = f"The root mean square {error}, {where}, is {100 * reached:.3g} % of the mean luminance"
        says += f"; {100 * asked:.3g} % was asked for."
        if not met:
            says += (
                " More samples would not help." if film.deterministic else " A few pixels may outweigh their judges."
            )
    return {"kind": stop.kind, "asked": asked, "reached": reached, "met": met, "says": says}


def relative_error(stop: RelativeErrorStop, film: Film) -> float | None:
    """The error that the contract asks for, as the film's own variances, or bounds, say; None where it is not known."""
    squares = film.layer("").variance() if film.bound is None else film.bound**2
    side = TILE if stop.per == "tile" else max(film.height, film.width)
    error, mean = math.sqrt(tiles(squares @ weights(film.channels), side).max()), film.mean_luminance()
    if error == 0:
        return 0.0
    return error / mean if math.isfinite(error) and mean > 0 else None
