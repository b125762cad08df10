"""Any phase function, piecewise linear in cos θ between the values of a table."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from woodcock.scene import TabulatedPhase
from woodcock.space import Array

FIELDS = {
    "backward": "float",
    "backward_most": "float",
    "forward_most": "float",
    "backward_first": "int",
    "backward_last": "int",
    "forward_first": "int",
    "forward_last": "int",
}
BUFFERS = {"versine": "float", "value": "float", "cumulative": "float"}


def halves(phase: TabulatedPhase) -> list[tuple[Array, Array, Array]]:
    """Versine, value and probability from the pole, from it to the equator, of the backward and the forward half.

    Versines are rounded to float32 before the table is normalised, so that what the device evaluates and what it
    samples are one and the same function.
    """
    cosine, value = np.array(phase.cosine), np.array(phase.value)
    value = value / value.max()
    middle = float(np.interp(0, cosine, value))
    both = []
    for side in (-1, 1):
        inside = side * cosine > 0
        versine = np.append((1 - side * cosine[inside])[::-side], 1).astype(np.float32).astype(float)
        values = np.append(value[inside][::-side], middle)
        steps = np.pi * np.diff(versine) * (values[:-1] + values[1:])
        both.append((versine, values, np.append(0, np.cumsum(steps))))
    total = sum(half[2][-1] for half in both)
    return [(versine, values / total, probability / total) for versine, values, probability in both]


def buffers(phase: TabulatedPhase) -> dict[str, np.ndarray[tuple[int], np.dtype[np.float32]]]:
    """The nodes of both halves, the backward one first."""
    parts = zip(*halves(phase), strict=True)
    return {name: np.concatenate(part).astype(np.float32) for name, part in zip(BUFFERS, parts, strict=True)}


def record(phase: TabulatedPhase, offsets: Mapping[str, int]) -> dict[str, float | int]:
    """The backward half's share, and where the halves lie; `most` keeps samples left of a half's last node."""
    backward, forward = halves(phase)
    first, split = offsets["versine"], offsets["versine"] + backward[0].size

    def below(share: float) -> float:
        return float(np.nextafter(np.float32(share), np.float32(0)))

    return {
        # Where nothing goes forward, all goes backward, however the sum was rounded.
        "backward": backward[2][-1] if forward[2][-1] > 0 else 1,
        "backward_most": below(backward[2][-1]),
        "forward_most": below(forward[2][-1]),
        "backward_first": first,
        "backward_last": split - 1,
        "forward_first": split,
        "forward_last": split + forward[0].size - 1,
    }


def _normalised(phase: TabulatedPhase) -> tuple[Array, Array]:
    cosine, value = np.array(phase.cosine), np.array(phase.value)
    value = value / value.max()
    return cosine, value / (np.pi * np.diff(cosine) @ (value[:-1] + value[1:]))


def evaluate(phase: TabulatedPhase, cosine: Array) -> Array:
    """Float64 oracle: p(cos θ), per steradian."""
    return np.interp(cosine, *_normalised(phase))


def mean_cosine(phase: TabulatedPhase) -> float:
    """The integral of a cubic a piece, by Simpson's rule, which is exact."""
    x, p = _normalised(phase)
    middle = (x[:-1] + x[1:]) * (p[:-1] + p[1:])
    ends = x * p
    return float(np.pi / 3 * np.diff(x) @ (ends[:-1] + middle + ends[1:]))


def cumulative(phase: TabulatedPhase, cosine: Array) -> Array:
    """Probability that a sample's cosine lies below: a quadratic a piece."""
    x, p = _normalised(phase)
    before = np.append(0, np.cumsum(np.pi * np.diff(x) * (p[:-1] + p[1:])))
    i = np.clip(np.searchsorted(x, cosine, side="right") - 1, 0, x.size - 2)
    return np.asarray(before[i] + np.pi * (cosine - x[i]) * (p[i] + np.interp(cosine, x, p)))
