"""Lanes of doubles: the same vocabulary as lanes of floats, in the precision that integrators without noise need."""

from __future__ import annotations

import re

import numpy as np
import pytest

from woodcock.deterministic import lanes_of
from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.program import ROOT


def test_vocabulary(context: Context, lanes: int) -> None:
    lanes = lanes_of(lanes, precise=True)
    x = np.linspace(0.01, 3.99, 64)
    single, at = x.astype(np.float32), x.astype(int)
    numbers = (np.arange(64) / 3).astype(np.float32)
    halves, large = numbers.astype(np.float16), np.arange(64, dtype=np.uint32) + 4_000_000_000
    expected = {
        "fma(x, x, -x)": x**2 - x,
        "-expm1(-x)": -np.expm1(-x),
        "pick((real)0.f, x, test(x > 1.f) & ~test(x > 2.f))": np.where((x > 1) & (x <= 2), x, 0),
        "smaller(larger(x, (real)1.f), (real)2.f)": np.clip(x, 1, 2),
        "to_real(clamp_index(to_integer(x), 2))": np.clip(at, 0, 1),
        "gather(float, numbers, to_integer(x))": numbers[at],
        "to_real(gather(uint, large, to_integer(x)))": large[at],
        "to_real(to_word(gather(ushort, halves, to_integer(x))))": halves.view(np.uint16)[at],
        "density_fetch(halves, to_integer(x))": halves[at],
        "some(test(x > 3.9f)) ? (real)1.f : (real)0.f": (x.reshape(-1, lanes) > 3.9).any(1).repeat(lanes),
        "word_as_real(to_word(x * 0x1p28f))": (x * 2**28).astype(np.uint32).view(np.float32),
        "lanes_as_float(x)": single,
        "box_exit(box, vector_of(x * 0.1f, x * 0.2f, x * 0.25f), vector_of(x, x, x))": (1 - x / 4) / x,
    }
    got = evaluate(
        context,
        list(expected),
        {"x": x},
        lanes=lanes,
        buffers={"numbers": numbers, "halves": halves.view(np.uint16), "large": large},
        parts=["core/rng.h", "core/vector.h", "core/box.h", "volume/grid_half.h"],
        body="vector3 box = {1.f, 1.f, 1.f};",
    )
    assert got.dtype == np.float64
    for (expression, right), found in zip(expected.items(), got, strict=True):
        assert np.allclose(found, right, rtol=3e-16 if "box" not in expression else 1e-7, atol=5e-16), expression


@pytest.mark.parametrize("width", [1, 4, 8])
def test_the_same_names_are_there(width: int) -> None:
    """What lanes of floats define, lanes of doubles do."""

    def names(file: str) -> set[str]:
        text = (ROOT / "core" / file).read_text()
        for include in re.findall(r'#include "core/(lanes_vector\w*\.h)"', text):
            text += (ROOT / "core" / include).read_text()
        return set(re.findall(r"#define (\w+)|(?:typedef .*[ ,]|int )(\w+)(?:;|, number;|\()", text))

    assert names(f"lanes_{width}.h") <= names(f"lanes_{width}_double.h")


def test_widths_follow_those_of_floats() -> None:
    assert [lanes_of(lanes, precise=True) for lanes in (1, 4, 8, 16)] == [1, 4, 4, 8]
    assert [lanes_of(lanes, precise=False) for lanes in (1, 4, 8, 16)] == [1, 4, 8, 16]
