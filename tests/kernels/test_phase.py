"""Every phase function: density against the float64 oracle, normalisation, mean cosine, chi-square of samples.

Kinds: isotropic, henyey_greenstein.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.stats import chisquare
from tests.conftest import SIGNIFICANCE
from tests.kernels.device_code import call

from woodcock.device import Context
from woodcock.layout import module
from woodcock.scene import HenyeyGreensteinPhase, IsotropicPhase

PHASES = [
    IsotropicPhase(),
    *(HenyeyGreensteinPhase(g=g) for g in (0, 1e-7, -1e-4, 0.3, -0.75, 0.95, -0.99, 0.9999, -0.9999)),
]
phases = pytest.mark.parametrize("phase", PHASES, ids=repr)


def unit_vectors(n: int, seed: int) -> np.ndarray:
    v = np.random.default_rng(seed).standard_normal((3, n))
    return (v / np.linalg.norm(v, axis=0)).astype(np.float32)


def run(context: Context, phase: Any, lanes: int, body: str, results: list[str], **inputs: np.ndarray) -> np.ndarray:
    record = module("phase", phase.kind).record(phase)
    return call(context, "phase", phase, record, body, results, inputs, lanes)


@phases
def test_eval_and_pdf(context: Context, lanes: int, phase: Any) -> None:
    """At random pairs of directions, and along the peak, where cos θ alone could not tell directions apart."""
    into, out = unit_vectors(512, 1), unit_vectors(512, 2)
    near = into[:, :256] + 10.0 ** -np.linspace(0, 8, 256) * unit_vectors(256, 3)
    out[:, :256] = np.copysign(1, getattr(phase, "g", 1)) * near / np.linalg.norm(near, axis=0)
    inputs = {f"{name}{axis}": v[i] for name, v in (("a", into), ("b", out)) for i, axis in enumerate("xyz")}
    vectors = "vector in = vector_of(ax, ay, az), out = vector_of(bx, by, bz);"
    name = f"phase_{phase.kind}"
    got, pdf = run(
        context, phase, lanes, vectors, [f"{name}_eval(kind, in, out)", f"{name}_pdf(kind, in, out)"], **inputs
    )
    # The oracle sees the same float32 vectors, made exactly unit.
    a, b = (v.astype(float) / np.linalg.norm(v.astype(float), axis=0) for v in (into, out))
    right = module("phase", phase.kind).evaluate(phase, (a * b).sum(axis=0))
    # Float32 vectors are unit to 1e-7 only, which a peak of width 1 - |g| sees enlarged.
    gap = 1 - abs(getattr(phase, "g", 0))
    assert np.allclose(got, right, rtol=1e-5 + 3e-7 / gap)
    assert np.array_equal(got, pdf)


@phases
def test_normalised_with_the_mean_cosine(phase: Any) -> None:
    """The oracle itself: its integral over the sphere is 1 and its mean cosine g."""
    kind = module("phase", phase.kind)
    # Tanh-spaced, so that nodes crowd where narrow peaks are.
    t = np.linspace(-18, 18, 20001)
    cosine, weight = np.tanh(t), np.gradient(t) / np.cosh(t) ** 2
    p = 2 * np.pi * kind.evaluate(phase, cosine) * weight
    assert p.sum() == pytest.approx(1, abs=1e-5)
    assert (p * cosine).sum() == pytest.approx(kind.mean_cosine(phase), abs=1e-5)


@phases
def test_samples_follow_the_density(context: Context, lanes: int, phase: Any) -> None:
    """Chi-square of cos θ in bins of equal probability, of the azimuth, mean cosine, unit length."""
    n = 1 << 17
    random = np.random.default_rng(17)
    u, v = random.random((2, n), dtype=np.float32)
    axis = np.array([0.48, -0.6, 0.64], np.float32)
    body = "vector in = vector_of((real)0.48f, (real)-0.6f, (real)0.64f);\n"
    body += f"vector s = phase_{phase.kind}_sample(kind, in, u, v);"
    s = run(context, phase, lanes, body, ["s.x", "s.y", "s.z"], u=u, v=v).astype(float)
    assert np.allclose(np.linalg.norm(s, axis=0), 1, atol=3e-7)

    # From the chord to the axis of the peak, not from the dot product: narrow peaks.
    side = np.copysign(1, getattr(phase, "g", 1))
    cosine = side * (1 - ((s - side * axis[:, None]) ** 2).sum(axis=0) / 2)
    kind = module("phase", phase.kind)
    if abs(getattr(phase, "g", 0)) < 0.999:
        probability = np.clip(kind.cumulative(phase, cosine), 0, 1)
        assert chisquare(np.histogram(probability, bins=64, range=(0, 1))[0]).pvalue > SIGNIFICANCE
    spread = cosine.std() / np.sqrt(n) + 1e-7
    assert abs(cosine.mean() - kind.mean_cosine(phase)) < 5 * spread

    across = np.cross(axis, [0, 0, 1])
    across /= np.linalg.norm(across)
    azimuth = np.arctan2(np.cross(axis, across) @ s, across @ s)
    assert chisquare(np.histogram(azimuth, bins=32, range=(-np.pi, np.pi))[0]).pvalue > SIGNIFICANCE


def test_sampling_is_pure_and_covers_the_ends(context: Context, lanes: int) -> None:
    """The uniforms' ends give finite unit vectors for every g."""
    u = np.array([0, 0, 1 - 2.0**-24, 1 - 2.0**-24, 0.5], np.float32)
    v = np.array([0, 1 - 2.0**-24, 0, 1 - 2.0**-24, 0.5], np.float32)
    for phase in PHASES:
        body = f"vector s = phase_{phase.kind}_sample(kind, vector_of((real)0.f, (real)0.f, (real)-1.f), u, v);"
        s = run(context, phase, lanes, body, ["s.x", "s.y", "s.z"], u=u, v=v)
        assert np.allclose(np.linalg.norm(s, axis=0), 1, atol=3e-7)
