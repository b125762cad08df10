"""Every phase function: density against the float64 oracle, normalisation, mean cosine, chi-square of samples.

Kinds: isotropic, henyey_greenstein, two_lobe, rayleigh, draine, mie_approx, tabulated, mixture.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.conftest import Rng
from tests.kernels.phase_code import exactly_unit, run, unit_vectors
from tests.statistics import accept_counts, accept_mean

from woodcock.device import Context
from woodcock.layout import module
from woodcock.scene import (
    DrainePhase,
    HenyeyGreensteinPhase,
    IsotropicPhase,
    MieApproxPhase,
    MixturePhase,
    RayleighPhase,
    TabulatedPhase,
    TwoLobePhase,
)
from woodcock.scene.phase import Component

RAGGED = TabulatedPhase(cosine=(-1, -0.9, -0.25, 0.1, 0.5, 0.7, 1), value=(3, 0, 0, 2, 0.5, 0, 7))
#: Each with the narrowest 1 - |g| it holds.
PHASES: list[tuple[Any, float]] = [
    (IsotropicPhase(), 1),
    *((HenyeyGreensteinPhase(g=g), 1 - abs(g)) for g in (0, 1e-7, -1e-4, 0.3, -0.75, 0.95, -0.99, 0.9999, -0.9999)),
    (TwoLobePhase(g1=0.95, g2=-0.4, weight=0.7), 0.05),
    (TwoLobePhase(g1=-0.9999, g2=0.9999, weight=0.4), 1e-4),
    (TwoLobePhase(g1=0.5, g2=-0.9, weight=1), 0.1),
    (RayleighPhase(), 1),
    *((DrainePhase(g=g, alpha=1), 1 - abs(g)) for g in (0, 1e-5, -0.6, 0.99, 0.9999, -0.9999)),
    *((DrainePhase(g=0.6, alpha=alpha), 0.4) for alpha in (0, 30, 1e8)),
    *((MieApproxPhase(diameter=d), 0.03) for d in (5, 20, 50)),
    (RAGGED, 1),
    (TabulatedPhase(cosine=(-1, 1), value=(0, 1e-300)), 1),
    (
        MixturePhase(
            components=(
                Component(weight=1, phase=HenyeyGreensteinPhase(g=0.9)),
                Component(weight=2, phase=RAGGED),
                Component(weight=0.5, phase=HenyeyGreensteinPhase(g=-0.7)),
                Component(weight=1.5, phase=TabulatedPhase(cosine=(-1, 0.5, 1), value=(1, 0, 9))),
                Component(weight=1, phase=TwoLobePhase(g1=0.5, g2=-0.4, weight=0.5)),
            )
        ),
        0.1,
    ),
    (MixturePhase(components=(Component(weight=1e300, phase=RayleighPhase()),)), 1),
]
phases = pytest.mark.parametrize(("phase", "gap"), PHASES, ids=[repr(phase)[:60] for phase, _ in PHASES])


def tolerance(gap: float) -> float:
    """Float32 vectors are unit to 1e-7 only, which a peak of width 1 - |g| sees enlarged."""
    return 1e-5 + 3e-7 / gap


@phases
def test_eval_and_pdf(context: Context, lanes: int, phase: Any, gap: float) -> None:
    """At random pairs of directions, and along the peaks, where cos θ alone could not tell directions apart."""
    into, out = unit_vectors(512, 1), unit_vectors(512, 2)
    near = into[:, :256] + 10.0 ** -np.linspace(0, 8, 256) * unit_vectors(256, 3)
    out[:, :256] = near / np.linalg.norm(near, axis=0) * np.resize([1, -1], 256)
    results = ["phase_eval(world, medium, in, out)"]
    if phase.kind != "mixture":
        names = getattr(module("phase", phase.kind), "BUFFERS", ())
        buffers = "".join(f"world->phase_{phase.kind}_{name}, " for name in names)
        results.append(f"phase_{phase.kind}_pdf(&world->scene->phase_0, {buffers}in, out)")
    got, *pdf = run(context, [phase], lanes, results, {"in": into, "out": out})
    # The oracle sees the same float32 vectors, made exactly unit.
    cosine = (exactly_unit(into) * exactly_unit(out)).sum(axis=0)
    right = module("phase", phase.kind).evaluate(phase, cosine)
    # Absolute only where the density vanishes: in zeros of a table, at cos θ = 0 for a large α.
    assert np.allclose(got, right, rtol=tolerance(gap), atol=2e-7)
    assert all(np.array_equal(got, values) for values in pdf)


@phases
def test_normalised_with_the_mean_cosine(phase: Any, gap: float) -> None:
    """The oracle itself: its integral over the sphere is 1 and its mean cosine as stated."""
    kind = module("phase", phase.kind)
    # Tanh-spaced, so that nodes crowd where narrow peaks are.
    t = np.linspace(-18, 18, 20001)
    cosine, weight = np.tanh(t), np.gradient(t) / np.cosh(t) ** 2
    p = 2 * np.pi * kind.evaluate(phase, cosine) * weight
    assert p.sum() == pytest.approx(1, abs=1e-5)
    assert (p * cosine).sum() == pytest.approx(kind.mean_cosine(phase), abs=1e-5)
    below = kind.cumulative(phase, np.array([-1.0, 0.2, 1.0]))
    assert below == pytest.approx([0, p[cosine < 0.2].sum(), 1], abs=2e-3)


@phases
def test_samples_follow_the_density(context: Context, lanes: int, phase: Any, gap: float, rng: Rng) -> None:
    """χ² of cos θ in bins of equal probability that are halved towards its ends, of the azimuth; mean cosine; unit
    length, at the ends too."""
    n = 1 << 17
    ends = np.meshgrid(*2 * [np.array([0, 2.0**-24, 0.5 - 2.0**-24, 0.5, 1 - 2.0**-24], np.float32)])
    u, v = np.concatenate([rng(17).random((2, n), dtype=np.float32), np.reshape(ends, (2, -1))], axis=1)
    axis = np.array([0.48, -0.6, 0.64], np.float32)
    body = "vector in = vector_of((real)0.48f, (real)-0.6f, (real)0.64f), s = phase_sample(world, medium, in, u, v);"
    results = ["s.x", "s.y", "s.z", "phase_eval(world, medium, in, s)"]
    *directions, density = run(context, [phase], lanes, results, {"u": u, "v": v}, body)
    assert np.allclose(np.linalg.norm(directions, axis=0), 1, atol=3e-7)
    assert np.all(np.isfinite(density))
    assert np.all(density >= 0)

    # From the chord to the nearer end of the axis, not from the dot product: narrow peaks.
    s = np.array(directions, float)[:, :n]
    side = np.copysign(1, axis.astype(float) @ s)
    cosine = side * (1 - ((s - side * axis[:, None]) ** 2).sum(axis=0) / 2)
    kind = module("phase", phase.kind)
    probability = np.clip(kind.cumulative(phase, cosine), 0, 1)
    tail = 2.0 ** -np.arange(11, 6, -1)  # 64 samples beyond the last
    edges = np.concatenate([[0], tail, np.arange(2, 127) / 128, 1 - tail[::-1], [1]])
    accept_counts(np.histogram(probability, edges)[0], np.diff(edges), "cosine")
    if gap > 0.01:  # a few samples make the mean of narrower peaks: the bins see them
        accept_mean(cosine, kind.mean_cosine(phase), "mean cosine")

    across = np.cross(axis, [0, 0, 1])
    across /= np.linalg.norm(across)
    azimuth = np.arctan2(np.cross(axis, across) @ s, across @ s)
    accept_counts(np.histogram(azimuth, bins=32, range=(-np.pi, np.pi))[0], what="azimuth")
