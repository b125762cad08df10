"""Free flights (analytic, delta) and transmittances (exact, ratio), in a medium of one density below its majorant.

Those that only the full loop has (decomposition; residual_ratio, ray_marching): test_estimators.py.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest
from tests.conftest import Rng
from tests.statistics import accept, accept_mean

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.layout import module

# One walk a lane through density 0.3 of a majorant of mean free path 0.25, over a length of 1.6; uniforms by address.
WALK = """
rng_address at = {lane, turn, (word)0u, 3u};
const real density = (real)%g, mean_free_path = (real)0.25f, length = (real)1.6f;
real t = (real)0.f, value = (real)1.f, survived = (real)0.f;
mask busy = (mask)-1;
while (some(busy)) {
    words w = rng_next(&at, busy);
    real u, depth = rng_flight(&at, w, &u);
    t = pick(t, t + depth * mean_free_path, busy);
    mask escape = test(t >= length), over;
    %s
    busy &= ~over;
}
"""
FLIGHT = """over = escape | free_flight_{kind}_collides(density, u);
    survived = pick(survived, (real)1.f, escape & busy);"""
SHADOW = """real next = value;
    over = transmittance_{kind}_step(&next, density, length, mean_free_path, escape, unit(w.y));
    value = pick(value, next, busy);"""


def walks(context: Context, lanes: int, kind: str, step: str, density: float, result: str, rng: Rng) -> np.ndarray:
    n = 1 << 16
    turn = np.full(n, rng(0).integers(1 << 32), np.uint32)
    return evaluate(
        context,
        [result],
        {"lane": np.arange(n, dtype=np.uint32), "turn": turn},
        lanes=lanes,
        parts=["core/rng.h", f"tracking/{kind}.h"],
        body=WALK % (density, step.format(kind=kind)),
    )[0].astype(float)


@pytest.mark.parametrize(("kind", "density"), [("analytic", 1), ("delta", 0.3), ("delta", 1), ("delta", 0)])
def test_flights_survive_as_the_oracle_says(context: Context, lanes: int, kind: str, density: float, rng: Rng) -> None:
    survived = walks(context, lanes, kind, FLIGHT, density, "survived", rng)
    depth = np.array(density * 1.6 / 0.25)
    oracle = module("tracking", kind)
    right = oracle.survival(depth) if kind == "delta" else oracle.survival(1 / 0.25, np.array(1.6))
    test = binomtest(int(survived.sum()), survived.size, min(float(right), 1))
    accept(test.pvalue, exact=1000 < survived.size * right < survived.size - 1000)


@pytest.mark.parametrize(
    ("kind", "density"), [("exact", 1), ("ratio", 0.3), ("ratio", 0.6), ("ratio", 0.9), ("ratio", 0)]
)
def test_transmittance_has_the_oracles_mean(context: Context, lanes: int, kind: str, density: float, rng: Rng) -> None:
    value = walks(context, lanes, kind, SHADOW, density, "value", rng)
    right = module("tracking", kind).transmittance(np.array(density * 1.6 / 0.25))
    # Of a denser medium few walks make the mean.
    accept_mean(value, right, allowed=1e-6 * right, exact=density < 0.5)
    if density in (0, 1):
        assert value.std() < 1e-6


def test_small_steps_add_up(context: Context, lanes: int) -> None:
    """A million steps, the first of a tenth of an ulp."""
    body = """
path p; p.t = (real)1.f; p.t_low = (real)0.f;
for (int i = 0; i < 1000000; ++i) path_advance(&p, step);
"""
    step = np.array([1e-8, 1e-6, 0], np.float32)
    parts = ["core/rng.h", "core/vector.h", "core/spectrum_1.h", "core/path.h"]
    (t,) = evaluate(context, ["p.t"], {"step": step}, lanes=lanes, parts=parts, body=body)
    assert np.allclose(t, 1 + 1e6 * step.astype(float), rtol=2e-7)
