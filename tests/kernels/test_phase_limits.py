"""Phase functions against what they reduce to, approximate, or are handed as a table."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.conftest import Rng
from tests.kernels.phase_code import run, unit_vectors
from tests.statistics import accept_mean

from woodcock.device import Context
from woodcock.layout import module
from woodcock.phase import draine, henyey_greenstein, mie_approx, rayleigh, tabulated
from woodcock.scene import (
    DrainePhase,
    HenyeyGreensteinPhase,
    IsotropicPhase,
    MieApproxPhase,
    Phase,
    RayleighPhase,
    TabulatedPhase,
)

COSINES = np.linspace(-1, 1, 101)


def test_draine_without_alpha_is_henyey_greenstein() -> None:
    got = draine.evaluate(DrainePhase(g=0.7, alpha=0), COSINES)
    assert got == pytest.approx(henyey_greenstein.evaluate(HenyeyGreensteinPhase(g=0.7), COSINES), rel=1e-14)


def test_draine_without_g_is_rayleigh() -> None:
    phase = DrainePhase(g=0, alpha=1)
    assert draine.evaluate(phase, COSINES) == pytest.approx(rayleigh.evaluate(RayleighPhase(), COSINES), rel=1e-14)
    assert draine.cumulative(phase, COSINES) == pytest.approx(rayleigh.cumulative(RayleighPhase(), COSINES), abs=1e-14)


@pytest.mark.parametrize("g", [-0.999, -0.3, 0.0999999, 0.1000001, 0.95])
def test_draine_cumulative_is_the_integral(g: float) -> None:
    phase, nodes = DrainePhase(g=g, alpha=7), np.tanh(np.linspace(-18, 18, 40001))
    p = 2 * np.pi * draine.evaluate(phase, nodes)
    sums = np.append(0, np.cumsum(np.diff(nodes) * (p[:-1] + p[1:]) / 2))
    assert np.allclose(draine.cumulative(phase, nodes), sums, atol=1e-6)


def inverts_the_distribution(context: Context, lanes: int, phase: Phase, *, rising: bool) -> bool:
    """Does each uniform give the cosine below which its share lies? Not just by the samples' histogram."""
    u = np.linspace(0, 1 - 2.0**-24, 4096).astype(np.float32)
    body = "vector in = vector_of((real)0.f, (real)0.f, (real)1.f), s = phase_sample(world, medium, in, u, (real)0.3f);"
    s = np.clip(run(context, [phase], lanes, ["s.z"], {"u": u}, body)[0].astype(float), -1, 1)
    kind = module("phase", phase.kind)
    share, slope = kind.cumulative(phase, s), 2 * np.pi * kind.evaluate(phase, s)
    return bool(np.all(abs(share - (u if rising else 1 - u.astype(float))) < 1.5e-6 + 3e-7 * slope))


@pytest.mark.parametrize("alpha", [0.5, 1.0, 30.0, 1e8])
@pytest.mark.parametrize("g", [0.0, 1e-6, -0.3, 0.62, 0.95])
def test_draine_samples_invert_the_distribution(context: Context, lanes: int, g: float, alpha: float) -> None:
    assert inverts_the_distribution(context, lanes, DrainePhase(g=g, alpha=alpha), rising=g >= 0)


@pytest.mark.parametrize(
    ("phase", "rising"),
    [
        (IsotropicPhase(), False),
        (RayleighPhase(), True),
        *((HenyeyGreensteinPhase(g=g), g >= 0) for g in (0, 1e-6, -0.3, 0.95)),
    ],
    ids=repr,
)
def test_samples_invert_the_distribution(context: Context, lanes: int, phase: Phase, rising: bool) -> None:
    assert inverts_the_distribution(context, lanes, phase, rising=rising)


def mie_mean_cosine(x: float, index: float) -> tuple[float, float]:
    """Asymmetry and scattering efficiency of a sphere of size parameter x: Bohren & Huffman (1983), ch. 4."""
    terms = int(x + 4.05 * x ** (1 / 3) + 10)
    log_derivative = np.zeros(terms + int(index * x) + 32)
    for k in range(log_derivative.size - 1, 0, -1):
        log_derivative[k - 1] = k / (index * x) - 1 / (log_derivative[k] + k / (index * x))
    psi, chi = [np.cos(x), np.sin(x)], [-np.sin(x), np.cos(x)]
    for n in range(1, terms + 1):
        psi.append((2 * n - 1) * psi[-1] / x - psi[-2])
        chi.append((2 * n - 1) * chi[-1] / x - chi[-2])
    n, ratio = np.arange(1, terms + 1), log_derivative[1 : terms + 1]
    p, before = np.array(psi[2:]), np.array(psi[1:-1])
    xi, xi_before = p - 1j * np.array(chi[2:]), before - 1j * np.array(chi[1:-1])

    def coefficient(m: NDArray[np.float64]) -> NDArray[np.complex128]:
        return np.asarray((m * p - before) / (m * xi - xi_before))

    a, b = coefficient(ratio / index + n / x), coefficient(index * ratio + n / x)
    efficiency = 2 / x**2 * ((2 * n + 1) * (abs(a) ** 2 + abs(b) ** 2)).sum()
    neighbours = (n * (n + 2) / (n + 1))[:-1] * (a[:-1] * a[1:].conj() + b[:-1] * b[1:].conj()).real
    own = (2 * n + 1) / (n * (n + 1)) * (a * b.conj()).real
    return 4 / x**2 * (neighbours.sum() + own.sum()) / efficiency, efficiency


@pytest.mark.parametrize("diameter", [5, 10, 20, 50])
def test_mie_approx_scatters_as_far_forward_as_mie_theory(diameter: float) -> None:
    """Droplets of about the diameter in green light. The fit is of the shape; its mean cosine follows within 0.02."""
    spheres = np.array([mie_mean_cosine(np.pi * diameter * s / 0.55, 1.333) for s in np.linspace(0.85, 1.15, 31)])
    expected = np.average(spheres[:, 0], weights=spheres[:, 1])
    assert mie_approx.mean_cosine(MieApproxPhase(diameter=diameter)) == pytest.approx(expected, abs=0.02)


def test_a_fine_table_is_what_it_was_made_from(context: Context, lanes: int) -> None:
    """Henyey & Greenstein, g = 0.999, in 4096 values that crowd at the peak."""
    phase = HenyeyGreensteinPhase(g=0.999)
    versine = np.append(0, np.geomspace(1e-9, 2, 4095))
    cosine = 1 - versine[::-1]
    table = TabulatedPhase(cosine=tuple(cosine), value=tuple(henyey_greenstein.evaluate(phase, cosine)))
    into = unit_vectors(2048, 1)
    out = into + np.geomspace(1e-6, 3, 2048) * unit_vectors(2048, 2)
    results = ["phase_eval(world, medium, in, out)"]
    inputs = {"in": into, "out": (out / np.linalg.norm(out, axis=0)).astype(np.float32)}
    assert np.allclose(
        run(context, [table], lanes, results, inputs), run(context, [phase], lanes, results, inputs), rtol=1e-3
    )


@pytest.mark.parametrize("side", [1, -1])
def test_a_peak_narrower_than_float32_tells_cosines_apart(context: Context, lanes: int, side: int, rng: Rng) -> None:
    """All light within 1e-8 of a pole, p falling linearly: the mean versine is a third of that."""
    narrow, steps = 1e-8, (-1, 0.2, 1 - 1e-8, 1)
    table = TabulatedPhase(cosine=tuple(side * c for c in steps[::side]), value=(0, 0, 0, 1)[::side])
    n = 1 << 14
    u, v = rng(3).random((2, n), dtype=np.float32)
    body = "vector in = vector_of((real)0.f, (real)0.f, (real)1.f), s = phase_sample(world, medium, in, u, v);"
    results = ["s.x", "s.y", "s.z", "phase_eval(world, medium, in, s)"]
    x, y, z, density = run(context, [table], lanes, results, {"u": u, "v": v}, body).astype(float)
    assert np.all(z * side > 0)
    versine = (x * x + y * y) / 2
    assert versine.max() < narrow * (1 + 1e-5)
    accept_mean(versine / narrow, 1 / 3)
    # Where the ramp ends, the density is the difference of two directions: absolute there.
    expected = (1 - versine / narrow) / (np.pi * narrow)
    assert np.allclose(density, expected, rtol=1e-4, atol=1e-4 / narrow)


def test_no_sample_falls_where_a_table_is_zero(context: Context, lanes: int) -> None:
    """Zeros at both poles, at the equator and between, for the uniforms next to every change of piece and others."""
    table = TabulatedPhase(cosine=(-1, -0.8, -0.6, -0.4, 0.3, 0.5, 0.6, 1), value=(0, 0, 2, 0, 0, 3, 0, 0))
    shares = np.unique(tabulated.cumulative(table, np.array(table.cosine)))
    near = (shares[:, None] + np.arange(-4, 5) * 2.0**-24).ravel()
    u = np.concatenate([near[(near >= 0) & (near < 1)], np.random.default_rng(1).random(4096)]).astype(np.float32)
    u = u[u < 1]
    body = "vector in = vector_of((real)0.f, (real)0.f, (real)1.f), s = phase_sample(world, medium, in, u, (real)0.2f);"
    cosine = run(context, [table], lanes, ["s.z"], {"u": u}, body)[0]
    slack = 1e-6
    back, ahead = (cosine > -0.8 - slack) & (cosine < -0.4 + slack), (cosine > 0.3 - slack) & (cosine < 0.6 + slack)
    assert np.all(back | ahead)
    assert np.all(cosine[u < shares[1] - 1e-6] < 0)


def test_a_table_counts_by_its_ratios() -> None:
    cosine, value = (-1, -0.5, 0.3, 1), np.array([1, 2, 0.5, 4])
    tables = [TabulatedPhase(cosine=cosine, value=tuple(value * 2.0**scale)) for scale in (0, 1000, -1000)]
    first, *others = (tabulated.buffers(table) for table in tables)
    for other in others:
        assert all(np.array_equal(first[name], other[name]) for name in tabulated.BUFFERS)
