"""Free flights and their choices far out: beyond 16 mean free paths, short flights, tiny probabilities.

Rare words are chosen, and only rare ones: given that a word lies below 2ᵏ, its uniform is uniform below 2ᵏ⁻³².
What follows it is hashed from real addresses.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import binom, chi2, kstest, poisson
from tests.statistics import accept, seed

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.probe import probe
from woodcock.program import OPTIONS, flatten

PARTS = ["core/rng.h"]
#: What the loops do with the words `w` of a step.
FLIGHT = "real u; real depth = rng_flight(&at, w, &u);"
DRAWN = 1 << 20


def flights(
    context: Context, lanes: int, x: NDArray[np.integer], w: NDArray[np.integer]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Optical depths and choices of steps whose first and last words are given, at addresses of their own."""
    body = f"""
rng_address at = {{address & 4095u, address >> 12u, (word)3u, {seed(7)}u}};
words w = {{x_in, x_in, w_in, w_in}};
{FLIGHT}"""
    inputs = {"x_in": x.astype(np.uint32), "w_in": w.astype(np.uint32), "address": np.arange(len(x), dtype=np.uint32)}
    depth, u = evaluate(context, ["depth", "u"], inputs, lanes=lanes, parts=PARTS, body=body).astype(np.float64)
    return depth, u


def below(bits: int, stream: int, n: int = DRAWN) -> NDArray[np.int64]:
    return np.random.default_rng(seed(stream)).integers(0, 1 << bits, n)


def accept_binomial(found: int, n: int, p: float, what: str) -> None:
    tail = min(binom.cdf(found, n, p), binom.sf(found - 1, n, p))
    accept(min(1.0, 2 * float(tail)), f"{what}: {found} of {n}, expected {n * p:.6g}", exact=False)


@pytest.mark.parametrize(("beyond", "bits"), [(16, 9), (17, 8), (20, 4), (24, 1), (27, 1), (30, 1)])
def test_flights_beyond_many_mean_free_paths_are_exponential(
    context: Context, lanes: int, beyond: int, bits: int
) -> None:
    depth, _ = flights(context, lanes, below(bits, beyond), below(32, beyond + 100))
    far = depth[depth > beyond] - beyond
    accept_binomial(len(far), DRAWN, np.exp(-beyond) * 2.0 ** (32 - bits), f"beyond {beyond}")
    accept(float(kstest(far, "expon").pvalue), f"law beyond {beyond}", exact=False)
    # As fine as a float is there, 2^-19: few of so many values come twice.
    assert len(np.unique(far[:4096])) > 0.98 * len(far[:4096])


@pytest.mark.parametrize("bits", [31, 22, 19, 18, 17, 10, 4])
def test_short_flights_are_exponential(context: Context, lanes: int, bits: int) -> None:
    """Uniforms within 2ᵏ⁻³² of 1: thin media live by them."""
    depth, _ = flights(context, lanes, (1 << 32) - 1 - below(bits, bits), below(32, bits + 100))
    q = 2.0 ** (bits - 32)
    # -expm1(-depth) is uniform below q, as coarse as a float near 1 where q is no small number.
    accept(float(kstest(-np.expm1(-depth[:65536]) / q, "uniform").pvalue), f"shorter than {q:.3g}", exact=False)
    assert depth.min() > 0 or bits > 18


@pytest.mark.parametrize("probability", [1e-12, 1e-9, 6.1e-8, 1e-7, 1.9e-7, 1e-6, 1e-5, 1e-3, 0.3])
def test_tiny_probabilities_are_met_as_often(context: Context, lanes: int, probability: float) -> None:
    probability = float(np.float32(probability))
    bits = max(1, int(np.ceil(np.log2(probability))) + 32)
    _, u = flights(context, lanes, below(32, 5), below(bits, 6))
    accept_binomial(int((u < probability).sum()), DRAWN, probability * 2.0 ** (32 - bits), f"u < {probability:.3g}")


def test_flights_and_choices_know_nothing_of_each_other(context: Context, lanes: int) -> None:
    """Also where the words of both go on with those of one more step."""
    depth, u = flights(context, lanes, below(1, 7), below(1, 8))
    depth, u = np.argsort(np.argsort(depth)), np.argsort(np.argsort(u))
    counts, *_ = np.histogram2d(depth, u, bins=16)
    statistic = float(((counts - DRAWN / 256) ** 2).sum() / (DRAWN / 256))
    accept(float(chi2.sf(statistic, 225)), "independence", exact=False)


def test_flights_end(context: Context, lanes: int) -> None:
    """No flight is infinite or negative, whatever its words."""
    w = np.array([0, 1, 255, 256, (1 << 19) - 1, 1 << 19, 1 << 31, (1 << 32) - 1, (1 << 31) - 1], np.int64)
    depth, u = flights(context, lanes, w, w)
    assert (depth >= 0).all()
    assert (depth < 45).all()
    assert ((u > 0) & (u <= 1)).all()


@pytest.mark.slow
def test_flights_of_real_streams_reach_beyond_20_mean_free_paths(context: Context) -> None:
    """2³⁴ steps: the first steps of 4096 pixels, 2²² samples each."""
    lanes, pixels, samples = probe(context.device).lanes[-1], 4096, 1 << 22
    text = f"""
__kernel void beyond(__global uint *result, uint first) {{
    word pixel = (word)((uint)get_global_id(0) * LANES) + integer_as_word(lane_index());
    integer beyond_14 = (integer)0, beyond_17 = (integer)0, beyond_20 = (integer)0;
    for (uint sample = first; sample < first + 65536u; ++sample) {{
        rng_address at = {{pixel, (word)sample, (word)1u, {seed(7)}u}};
        words w = rng_next(&at, (mask)-1);
        {FLIGHT}
        beyond_14 -= test(depth > 14.f);
        beyond_17 -= test(depth > 17.f);
        beyond_20 -= test(depth > 20.f);
    }}
    __global uint *own = result + (uint)get_global_id(0) * LANES;
    lanes_store(integer_as_word(beyond_14), own);
    lanes_store(integer_as_word(beyond_17), own + {pixels});
    lanes_store(integer_as_word(beyond_20), own + {2 * pixels});
}}
"""
    kernel = context.build(flatten([f"core/lanes_{lanes}.h", *PARTS, text]), OPTIONS, "beyond")
    counts, total = np.zeros((3, pixels), np.uint32), np.zeros(3, np.int64)
    buffer = context.output(counts)
    for first in range(0, samples, 65536):
        kernel(context.queue, (pixels // lanes,), None, buffer, np.uint32(first))
        context.download(counts, buffer)
        total += counts.sum(axis=1, dtype=np.int64)
    for beyond, found in zip((14, 17, 20), total, strict=True):
        expected = pixels * samples * np.exp(-beyond)
        tail = min(poisson.cdf(found, expected), poisson.sf(found - 1, expected))
        accept(min(1.0, 2 * float(tail)), f"beyond {beyond}: {found}, expected {expected:.1f}", exact=False)
