"""Sums of a pixel's samples on the device: as exact as float64's."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from woodcock.device import Context
from woodcock.evaluate import evaluate

COUNT = 4096
BODY = f"""
moments m = {{0}};
for (int i = 0; i < {COUNT}; ++i) moments_add(&m, (real)values[i]);
"""


def test_sums_are_exact_to_48_bits(context: Context, lanes: int) -> None:
    """Of samples that differ by many orders, and whose squares float32 rounds."""
    values = np.exp(np.random.default_rng(7).normal(0, 4, COUNT)).astype(np.float32)
    results = ["m.sum", "m.sum_low", "m.square", "m.square_low"]
    high, low, square, square_low = evaluate(
        context,
        results,
        {"unused": np.zeros(lanes, np.float32)},
        lanes=lanes,
        parts=["core/precision_float.h", "core/rng.h", "core/moments.h"],
        buffers={"values": values},
        body=BODY,
    ).astype(float)
    exact = [Fraction(float(value)) for value in values]
    for got, right in ((high + low, sum(exact)), (square + square_low, sum(value * value for value in exact))):
        assert np.abs(got / float(right) - 1).max() < 2.0**-42
