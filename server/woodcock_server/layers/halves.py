"""Numbers as IEEE half floats under a common scale: what a browser draws with, at half of the bytes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

#: The largest finite value comes to at most 2^15: halves hold 65504, and mixing several does not overflow at once.
TOP = 15


def scale_of(values: NDArray[np.float32]) -> float:
    """The power of two by which the values are divided, so that the largest finite one fits and small ones keep their
    digits: 2^39 times smaller ones still differ from 0."""
    sizes = np.abs(values)
    largest = float(np.max(sizes, where=np.isfinite(sizes), initial=0.0))
    return math.ldexp(1.0, math.frexp(largest)[1] - TOP) if largest > 0 else 1.0


def halves(values: NDArray[np.float32], scale: float) -> bytes:
    """Little-endian halves of values / scale, in their order; NaN and infinities stay what they are."""
    out = np.empty(values.shape, "<f2")
    for row, into in zip(values, out, strict=True):  # a row at a time: a whole picture's float64 would be large
        into[...] = row.astype(np.float64) / scale
    return out.tobytes()
