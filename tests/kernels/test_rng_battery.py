"""Dieharder on addressed random numbers, in the orders in which a render takes them."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.kernels import dieharder
from tests.kernels.dieharder import AMBIGUOUS, Test, battery, p_values
from tests.kernels.rng_streams import Stream, high_bits, low_bits, reversed_bits, words
from tests.statistics import SIGNIFICANCE, accept, least, seed

from woodcock.device import Context
from woodcock.probe import probe

#: Birthdays, ranks of matrices, bit streams, ones in bytes, distances, runs of bits, tuples of bits, lagged sums,
#: bytes, a cosine transform, fill trees and ones in blocks: those of dieharder's tests that it trusts, in seconds each.
TESTS = (
    *(Test(0, 0, 40), Test(2, 0, 10), Test(4, 0, 50), Test(8, 0, 100), Test(11, 0, 50), Test(15, 0, 100)),
    *(Test(100, 0, 100), Test(102, 8, 50), Test(200, 8, 30), Test(203, 3, 20)),
    *(Test(205), Test(206), Test(207), Test(209)),
)
QUICK = (Test(8, 0, 20), Test(100, 0, 40), Test(206))

PIXELS = Stream("i % 2073600u", "i / 2073600u", "(word)0u")  # of a picture of 1920 × 1080
SAMPLES = Stream("(word)12345u", "i", "(word)1u")
PATHS = Stream("i >> 13u", "(i >> 7u) & 63u", "i & 127u")
STREAMS = {
    "pixels": PIXELS,
    "pixels, then steps, then samples": Stream("i & 4095u", "i >> 18u", "(i >> 12u) & 63u"),
    "samples": SAMPLES,
    "steps of paths": PATHS,
    "one long path": Stream("(word)777u", "(word)3u", "i"),
    "seeds": Stream("i >> 8u", "(word)0u", "(word)0u", seed="i & 255u"),
    "x of samples": replace(SAMPLES, parts="x"),
    "w of samples": replace(SAMPLES, parts="w"),
    "what uniforms take, of pixels": replace(PIXELS, packed=high_bits),
    "what uniforms leave, of samples": replace(SAMPLES, packed=low_bits),
    "what uniforms leave, of paths": replace(PATHS, packed=low_bits),
    "lowest bits first, of pixels": replace(PIXELS, packed=reversed_bits),
    "lowest bits first, of paths": replace(PATHS, packed=reversed_bits),
    "deep words": Stream("i & 4095u", "i >> 12u", "(word)1u", hashed="rng_words(&at, ~at.dimension)"),
}
#: Generators that are known to be weak, each over the stream that shows it: the published hash without the mixing of
#: its halves, whose low bits are biased, and a counter times a constant.
WEAK = {
    "pcg4d": replace(SAMPLES, hashed="pcg4d((words){at.pixel, at.sample, at.dimension, (word)at.seed})", parts="w"),
    "counter": replace(SAMPLES, hashed="(words){i * 747796405u, i * 1664525u, i * 2891336453u, i * 277803737u}"),
}


@pytest.fixture(autouse=True)
def _dieharder() -> None:
    dieharder.require()


def made(context: Context, stream: Stream) -> dieharder.Words:
    """Seeds are one a program elsewhere, so only single lanes have one each."""
    own = stream if "i" in stream.seed else replace(stream, seed=f"{seed(7)}u")
    return words(context, own, 1 if "i" in stream.seed else probe(context.device).lanes[-1])


@pytest.mark.parametrize("name", ["samples", "steps of paths"])
def test_a_quick_battery(context: Context, name: str) -> None:
    accept(*battery(QUICK, made(context, STREAMS[name])), exact=False)


@pytest.mark.slow
@pytest.mark.parametrize("name", STREAMS)
def test_the_battery(context: Context, name: str) -> None:
    accept(*battery(TESTS, made(context, STREAMS[name])), exact=False)


@pytest.mark.parametrize(("name", "test"), [("pcg4d", Test(205)), ("counter", Test(206))])
def test_the_battery_has_teeth(context: Context, name: str, test: Test) -> None:
    assert AMBIGUOUS * least(p_values(test, made(context, WEAK[name]))) < SIGNIFICANCE
