"""The oracles of the sweep, against published values, scipy's quadrature and simple limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import binom, norm

from woodcock.stability import exact, judging
from woodcock.stability.cases import CASES

VALUES = np.random.default_rng(8).random((3, 4, 5))


@pytest.mark.parametrize(
    ("albedo", "mu", "radiance"),
    [(0.2, 0.1, 0.082660), (0.2, 1, 0.035231), (0.5, 0.5, 0.160144), (0.9, 0.5, 0.507939), (0.99, 1, 0.752721)],
)
def test_half_spaces_by_chandrasekhar(albedo: float, mu: float, radiance: float) -> None:
    assert exact.half_space(albedo, mu) == pytest.approx(radiance, abs=1e-6)


def test_faint_half_spaces_scatter_once() -> None:
    """ω/2 ∫ μ′ / (1 + μ′) dμ′."""
    assert exact.half_space(1e-6) == pytest.approx(0.5e-6 * (1 - math.log(2)), rel=1e-5)


def test_slabs_that_lose_nothing_are_white() -> None:
    for g in (-0.9, 0.0, 0.5, 0.9):
        assert exact.lit_slab(1.0, g, 3.0) == pytest.approx(1, abs=1e-7)


def test_slabs_that_scatter_nothing_let_through() -> None:
    assert exact.lit_slab(0.0, 0.5, 2.0) == pytest.approx(math.exp(-2), rel=1e-10)


def test_deep_slabs_are_half_spaces() -> None:
    assert exact.lit_slab(0.9, 0.0, 60.0) == pytest.approx(exact.half_space(0.9), rel=1e-6)


@pytest.mark.parametrize("g", [-0.5, 0.75])
def test_slabs_that_scatter_once(g: float) -> None:
    """Reflected and transmitted: ω/2 ∫∫ p, by quadrature."""
    tau, albedo = 1.0, 1e-6

    def mean(mu: float) -> float:
        """p averaged over azimuth about the view, which is p itself: times 4π."""
        return (1 - g * g) / (1 + g * g - 2 * g * mu) ** 1.5

    def along(mu: float) -> float:
        back = (1 - math.exp(-tau * (1 + 1 / mu))) / (1 + mu) * mu
        on = (math.exp(-tau) - math.exp(-tau / mu)) / (1 - 1 / mu) if mu != 1 else tau * math.exp(-tau)
        return mean(-mu) * back + mean(mu) * -on

    once = albedo / 2 * quad(lambda mu: along(mu), 0, 1)[0]
    found = exact.lit_slab(albedo, g, tau) - math.exp(-tau)
    assert found == pytest.approx(once, rel=1e-4)


def test_rods_that_lose_nothing_are_white() -> None:
    assert exact.rod(1 - 1e-13, 3.0) == pytest.approx(1, abs=1e-6)
    assert exact.rod(0.5, 1e-9) == pytest.approx(1, abs=1e-8)


def field(points: np.ndarray) -> np.ndarray:
    """Trilinear, clamped: `VALUES` at points of the unit cube, by numpy's interpolation along one axis at a time."""
    found = []
    for x, y, z in points:
        plane = np.array([[np.interp(x * 5 - 0.5, range(5), row) for row in layer] for layer in VALUES])
        line = [np.interp(y * 4 - 0.5, range(4), layer) for layer in plane]
        found.append(np.interp(z * 3 - 0.5, range(3), line))
    return np.array(found)


def test_depths_of_rays_are_those_of_the_midpoint_rule() -> None:
    origin, direction = np.array([0.1, 0.2, -1.0]), np.array([0.2, 0.1, 1.0])
    t = 1 + (np.arange(2000) + 0.5) / 2000  # where the ray is in the cube
    depth = field(origin + t[:, None] * direction).mean() * np.linalg.norm(direction)
    assert exact.depth_of_ray(VALUES, origin, direction) == pytest.approx(depth, rel=1e-6)


def test_columns_are_rays_along_z() -> None:
    through = exact.through_columns(VALUES, np.array([0.37, 0.9]), np.array([0.05]))
    rays = [exact.depth_of_ray(VALUES, np.array([x, 0.05, -1]), np.array([0, 0, 1])) for x in (0.37, 0.9)]
    assert np.allclose(through, np.exp(-np.array([rays])), rtol=1e-13)


def test_means_of_columns_are_those_of_many() -> None:
    fine = exact.middles(400)
    assert exact.through_columns_mean(VALUES) == pytest.approx(
        exact.through_columns(VALUES, fine, fine).mean(), rel=1e-5
    )


@pytest.mark.parametrize("column", [[1, 50, 0.001, 30, 3], [1e-7, 1e5, 1e-7], [3.0], [0.0, 0.0], [0.0, 1e6]])
def test_emission_along_a_column(column: list[float]) -> None:
    z = np.concatenate([np.geomspace(1e-12, 0.5, 400000), np.linspace(0.5, 1, 400000)[1:]])
    z = np.insert(z, 0, 0.0)
    sigma = np.interp(z * len(column) - 0.5, range(len(column)), column)
    tau = np.concatenate([[0.0], np.cumsum((sigma[1:] + sigma[:-1]) / 2 * np.diff(z))])
    right = float(np.trapezoid(np.exp(-tau), z))
    assert exact.emitted(np.array(column)) == pytest.approx(right, rel=1e-6)


@pytest.mark.parametrize("tau", [1e-6, 0.9e-3, 1.1e-3, 1.0, 30.0])
def test_spread_of_a_flight(tau: float) -> None:
    square = quad(lambda t: t * t * math.exp(-t), 0, tau, epsabs=0)[0] + tau**2 * math.exp(-tau)
    found = exact.slab_spread(tau) ** 2
    assert found == pytest.approx(square - exact.slab(tau) ** 2, rel=1e-3 if tau < 1e-2 else 1e-9, abs=1e-13)


@pytest.mark.parametrize(
    ("hits", "trials", "chance"), [(0, 4096, 1e-3), (12, 4096, 1e-3), (2000, 4096, 0.5), (7, 9, 0.2)]
)
def test_deviations_of_hits_are_the_binomial_laws(hits: int, trials: int, chance: float) -> None:
    tail = min(binom.cdf(hits, trials, chance), binom.sf(hits - 1, trials, chance))
    found = judging.equivalent_deviation(hits, trials, chance)
    assert abs(found) == pytest.approx(norm.isf(tail), rel=1e-6)
    assert (found > 0) == (hits > trials * chance)


def test_the_limit_is_that_of_all_cases() -> None:
    random = sum(case.random for case in CASES)
    assert random <= judging.MOST_RANDOM
    assert judging.MOST_RANDOM * 2 * norm.sf(judging.LIMIT) <= 1.01e-4
