"""Programs of the integrators without random numbers: numbers in double precision, and films with bounds.

exp(-τ) is to be right to 1e-5 at any τ where float32 can express it: at τ = 87 that asks for τ to 1e-7, which float32
cannot hold. So where a device has doubles, these programs run on lanes of doubles, and every number of the scene's
record is eight bytes wide; elsewhere they run on floats, and the bound says what that costs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from woodcock.batches import Batches
from woodcock.faults import Faults
from woodcock.film import Film
from woodcock.space import Array


def lanes_of(lanes: int, *, precise: bool) -> int:
    """Lanes of a program on a device that runs `lanes` of floats: doubles are twice as wide."""
    return lanes // 2 if precise and lanes > 4 else lanes


def film(
    sums: NDArray[np.float32],
    samples: tuple[int, int],
    size: tuple[int, int],
    names: tuple[str, ...],
    exponents: Array,
    faults: Faults,
) -> Film:
    """The Film of a launch of the samples [start, stop).

    sums: (channels, 4, at least pixels), as the kernel leaves them: a pair of the sum of values and one of the sum of
    bounds on their errors; size: (height, width); exponents: of two, of the channels' units.
    """
    (height, width), (start, stop) = size, samples
    pairs = sums[..., : width * height].astype(np.float64)
    value, bound = ((pairs[:, plane] + pairs[:, plane + 1]).T.reshape(height, width, -1) for plane in (0, 2))
    stored = value * 2.0**-24 + 2.0**-149  # what a picture of floats leaves of a number
    mean, bound = (np.ldexp(total / (stop - start), exponents) for total in (value, bound + stored))
    count = np.full((height, width), stop - start, np.uint32)
    return Film(count, mean, np.zeros(mean.shape), names, (samples,), faults, Batches(1), bound)
