"""How many samples pixels need for a relative error, so that their means stay unbiased: pixels are judged by others.

"Stop when the variance seems low" is a bias: where values have a heavy tail, a pixel that has not met its large ones
yet has both too small a mean and too small a variance, and stops. Whether it stops must not depend on its own values.
So pixels have one of four colours in a ring, and a colour's number of samples is decided by the samples of the next
colour alone. Random numbers are addressed by pixel: those are independent of its own. Given its number n, the pixel's
samples have the law that they always have: their mean is unbiased, and so is its variance s² / n.

Later decisions are made of more samples of the judges, and how many they had was decided by their own judges. So a
colour's second number depends on the next two colours, its third on all the others, and only its fourth on values of
its own: by how many samples its judges' judges' judges had, and by that alone.

Let the colours' variances in a tile be v₀ … v₃. Each has a number of samples in proportion to the next one's, and the
tile's mean square error is in proportion to v₀/v₁ + v₁/v₂ + v₂/v₃ + v₃/v₀: what judges are off by cancels in the first
order.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from woodcock.batches import TILE, tiles
from woodcock.film import Film, weights
from woodcock.scene import RelativeErrorStop
from woodcock.space import Array

#: What is aimed at, of the error that was asked for. Numbers that meet what was asked are left as they are, so that
#: what the judges learn afterwards does not lead to rounds of a few samples more.
AIM = 0.97


#: In a ring: each is judged by the next.
COLOURS = 4


@lru_cache(maxsize=1)
def colours(height: int, width: int) -> NDArray[np.uint8]:
    """(height, width): of 2 × 2 pixels, one of each colour, by chance which: a board with a pattern would hide the same
    pattern from a colour, as a chess board does diagonals."""
    rows, columns = -(-height // 2), -(-width // 2)
    random = np.random.PCG64(0).random_raw(rows * columns * COLOURS)  # numpy will never change these numbers
    blocks = np.argsort(random.reshape(rows, columns, COLOURS), axis=-1).astype(np.uint8).reshape(rows, columns, 2, 2)
    return blocks.swapaxes(1, 2).reshape(2 * rows, 2 * columns)[:height, :width]


def needed(stop: RelativeErrorStop, film: Film) -> Array:
    """(height, width): the samples of a pixel that the contract asks for, by what its judges say; never fewer than the
    film has. Every pixel must have two. The pixel of a picture of one has no judge but itself.
    """
    beauty, channels = film.layer(""), weights(film.channels)
    variance = (beauty.variance() * film.count[..., None]) @ channels  # of a sample
    luminance = beauty.mean @ channels
    side = TILE if stop.per == "tile" else max(film.height, film.width)
    board, samples = colours(film.height, film.width), film.count.astype(np.float64)
    ring = np.unique(board)  # the smallest pictures do not have all of them
    for colour, following in zip(ring, np.roll(ring, -1), strict=True):
        judged, judges = board == colour, (board == following) & np.isfinite(variance)
        if not (judges.any() and luminance[judges].mean() > 0):
            continue  # Nobody has seen any light.
        square = (stop.relative_error * luminance[judges].mean()) ** 2
        asked = _verdict(variance, judges, judged, side) / square
        lacking = judged & (asked > samples)
        samples[lacking] = asked[lacking] / AIM**2
    return samples


def _verdict(variance: Array, judges: NDArray[np.bool_], judged: NDArray[np.bool_], side: int) -> Array:
    """The variance of a sample, mean over a tile's judged pixels, that their judges expect, and one standard error
    more; (height, width), the same in a tile.

    A pixel's judges are next to it, also beyond its tile's border, so that what a tile has in a corner is not missed.
    """
    local, squares = (_nearby(np.where(judges, variance, 0.0) ** power, judges) for power in (1, 2))
    share = tiles(judged.astype(np.float64), side)
    mean, square = (
        np.divide(tiles(judged * each, side), share, out=np.zeros(share.shape), where=share > 0)
        for each in (local, squares)
    )
    height, width = variance.shape
    rows, columns = (np.arange(length) // side for length in (height, width))
    pixels = share * np.outer(np.bincount(rows), np.bincount(columns))
    error = np.sqrt(np.maximum(square - mean**2, 0) / np.maximum(pixels, 1))
    return np.asarray((mean + error)[np.ix_(rows, columns)])


def _nearby(values: Array, judges: NDArray[np.bool_]) -> Array:
    """Mean of the judges' values among the 3 × 3 pixels around each; of all judges where there is none of them.

    values: 0 where no judge is."""
    number = _around(judges.astype(np.float64))
    everywhere = np.full(values.shape, values.sum() / judges.sum())
    return np.asarray(np.divide(_around(values), number, out=everywhere, where=number > 0))


def _around(picture: Array) -> Array:
    """Sums over the 3 × 3 pixels around each."""
    rows = np.pad(picture, 1)
    rows = rows[:-2] + rows[1:-1] + rows[2:]
    return np.asarray(rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:])
