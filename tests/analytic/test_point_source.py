"""Point source: the fluence around an isotropic unit point source in an infinite medium that scatters isotropically,
σ_t = 1, has digits in Case, de Hoffmann & Placzek, "Introduction to the theory of neutron diffusion" (1953).

By reciprocity a ball of ε = 1 around the camera shines ∫ 4π r² φ(r) dr into it from every direction alike, so the
difference of two balls, red and green in one picture, is the fluence in a shell; nothing in it is singular. The other
way round, a camera at r sees what of a point light's fluence has been scattered: by next-event estimation and
equiangular sampling.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.optimize import brentq
from tests.analytic.scenes import Grid, Kind, Picture, Scene, ball, constant, cuboid, is_clean, random_walk
from tests.statistics import accept_z

from woodcock.film import Film

RADII = (0.1, 0.5, 1, 2, 5, 10)
#: φ at RADII, by ω: the digits as published.
PUBLISHED = {
    0.5: (8.032104, 0.2947631, 5.869514e-2, 7.927624e-3, 1.291324e-4, 4.608671e-7),
    0.9: (8.918977, 0.4828327, 0.1432839, 3.712640e-2, 2.915125e-3, 1.048972e-4),
}
#: Where the medium ends: what comes back from there is below 1e-20 of what is measured.
END = 60.0
#: Half a shell's thickness, relative to its radius.
HALF = 0.05


def fluence(albedo: float, moment: Any) -> float:
    """Σ of the discrete mode and the continuum, ∫ (weight of e^{-κr}) moment(κ) dκ: φ(r) for e^{-κr} / 4πr."""
    rate = brentq(lambda k: albedo * np.arctanh(k) / k - 1, 1e-6, 1 - 1e-15)
    discrete = 2 * rate**2 * (1 - rate**2) / (albedo * (rate**2 - 1 + albedo))

    def continuum(mu: float) -> float:
        """κ = 1 / μ."""
        density = (1 - albedo * mu * np.arctanh(mu)) ** 2 + (np.pi * albedo * mu / 2) ** 2
        return float(moment(1 / mu) / (mu**2 * density))

    return float(discrete * moment(rate) + quad(continuum, 0, 1, epsabs=0, epsrel=1e-11, limit=400)[0])


def at(albedo: float, radius: float) -> float:
    return fluence(albedo, lambda k: np.exp(-k * radius) / (4 * np.pi * radius))


def within(albedo: float, inner: float, outer: float) -> float:
    """∫ 4π r² φ dr from inner to outer."""

    def moment(k: float) -> float:
        return float((inner / k + 1 / k**2) * np.exp(-k * inner) - (outer / k + 1 / k**2) * np.exp(-k * outer))

    return fluence(albedo, moment)


@pytest.mark.parametrize("albedo", PUBLISHED)
def test_the_oracle_has_the_published_digits(albedo: float) -> None:
    assert [float(f"{at(albedo, r):.7g}") for r in RADII] == [float(f"{value:.7g}") for value in PUBLISHED[albedo]]
    for r in RADII:
        by_numbers, _ = quad(lambda x: 4 * np.pi * x**2 * at(albedo, x), 0.95 * r, 1.05 * r, epsrel=1e-10)
        assert within(albedo, 0.95 * r, 1.05 * r) == pytest.approx(by_numbers, rel=1e-8)
    assert within(albedo, 1e-9, END) == pytest.approx(1 / (1 - albedo), rel=1e-7)


def shell(medium: Kind, radius: float) -> Scene:
    """Seen from the middle: green is the ball to (1 + HALF) radius, red that to (1 - HALF) radius."""
    glow = {0: [1, 0, 0], 1: [0, 1, 0]}
    balls = [
        constant(ball((0, 0, 0), radius * (1 + side * HALF)), 0, 0, emission={"kind": "constant", "epsilon": glow[i]})
        for i, side in enumerate((-1, 1))
    ]
    camera = {"kind": "spherical", "origin": [0, 0, 0], "target": [0, 0, 1]}
    return random_walk({"camera": camera, "volumes": [medium, *balls], "film": {"width": 64, "height": 64}, "seed": 31})


def check(fluence: float, error: float, expected: float, within: float, what: str) -> None:
    """Is it as published, and known to `within` of that?"""
    assert error <= within * expected, f"{what}: known to {error / expected:.2g} only"
    accept_z((fluence - expected) / error, what)


def check_shell(film: Film, albedo: float, radius: float, error: float) -> None:
    assert is_clean(film)
    # Every pixel is like every other. Red and green share their paths: pixels are what is independent.
    pixels = (film.mean[..., 1] - film.mean[..., 0]).reshape(-1)
    to_fluence = at(albedo, radius) / within(albedo, radius * (1 - HALF), radius * (1 + HALF))
    deviation = pixels.std(ddof=1) / np.sqrt(pixels.size)
    expected = PUBLISHED[albedo][RADII.index(radius)]
    check(to_fluence * pixels.mean(), to_fluence * deviation, expected, error, f"ω = {albedo}, r = {radius}")


#: The largest standard error, relative: a bias of .5 % is 7.7 of them.
EXACT = 6.5e-4


def rows(*cases: tuple[float, float, int, float]) -> list[Any]:
    return [pytest.param(*case, id=f"{case[0]}-{case[1]}-{case[3]}") for case in cases]


def slow(*cases: tuple[float, float, int, float]) -> list[Any]:
    marks = (pytest.mark.slow, pytest.mark.timeout(7200))
    return [pytest.param(*case.values, id=case.id, marks=marks) for case in rows(*cases)]


@pytest.mark.parametrize(
    ("albedo", "radius", "samples", "error"),
    [
        *rows((0.5, 0.1, 90, EXACT), (0.5, 0.5, 250, EXACT), (0.5, 1, 440, EXACT), (0.5, 2, 1100, EXACT)),
        *rows((0.5, 5, 1200, 2e-3), (0.5, 10, 2600, 1e-2)),
        *rows((0.9, 0.1, 250, EXACT), (0.9, 0.5, 540, EXACT), (0.9, 1, 560, EXACT), (0.9, 2, 520, EXACT)),
        *rows((0.9, 5, 800, EXACT), (0.9, 10, 540, 2e-3)),
        *slow((0.5, 5, 10000, EXACT), (0.5, 10, 500000, EXACT), (0.9, 10, 3600, EXACT)),
    ],
)
def test_fluence_in_shells(picture: Picture, albedo: float, radius: float, samples: int, error: float) -> None:
    film = picture(shell(constant(ball((0, 0, 0), END), 1, albedo), radius), samples)
    check_shell(film, albedo, radius, error)


@pytest.mark.parametrize("majorant", [{"kind": "global"}, {"kind": "grid", "resolution": 5}], ids=str)
def test_fluence_in_shells_of_a_grid(picture: Picture, grid: Grid, majorant: Kind) -> None:
    """The medium by tracking under a majorant."""
    placed = [[2 * END, 0, 0, -END], [0, 2 * END, 0, -END], [0, 0, 2 * END, -END], [0, 0, 0, 1]]
    medium = grid(np.full((3, 2, 4), 0.5, np.float32), albedo=0.9, scale=2, to_world=placed)
    check_shell(picture(shell(medium, 1) | {"majorant": majorant}, 128), 0.9, 1, 2e-3)


def solid_angles(width: int, height: int) -> NDArray[np.float64]:
    """(height, 1): of a pixel of each row of a picture of all directions."""
    edges = np.cos(np.linspace(0, np.pi, height + 1))
    return 2 * np.pi / width * (edges[:-1] - edges[1:])[:, None]


@pytest.mark.parametrize(
    ("albedo", "radius", "samples", "error"),
    [
        *rows((0.5, 0.1, 270, 6e-3), (0.5, 0.5, 270, 3e-3), (0.5, 1, 440, 3e-3)),
        *slow((0.5, 0.1, 4400, EXACT), (0.5, 0.5, 4400, EXACT), (0.5, 1, 10000, EXACT)),
        *slow((0.9, 0.1, 600, 2e-3), (0.9, 0.5, 600, 2e-3)),
    ],
)
def test_scattered_fluence_of_a_point_light(
    picture: Picture, albedo: float, radius: float, samples: int, error: float
) -> None:
    """∫ L over all directions, and what the camera does not see: the light itself, e^{-r} / 4πr².

    A flight that passes the light at distance D has a share like 1 / D, so errors fall a little slower than 1 / √n.
    """
    width, height = 64, 128
    scene = random_walk(
        {
            # The light lies on the picture's equator, where pixels next to it see equal solid angles in either half.
            "camera": {"kind": "spherical", "origin": [radius, 0, 0], "target": [radius, 0, 1]},
            "volumes": [constant(cuboid(-12, 12) if radius == 0.5 else ball((0, 0, 0), 12), 1, albedo)],
            "lights": [{"kind": "point", "position": [0, 0, 0], "intensity": 1 / (4 * np.pi)}],
            "film": {"width": width, "height": height},
            "seed": 32,
        }
    )
    film = picture(scene, samples)
    assert is_clean(film)
    weights = solid_angles(width, height)
    scattered = float((film.mean[..., 0] * weights).sum())
    deviation = float(np.sqrt((film.variance()[..., 0] * weights**2).sum()))
    expected = PUBLISHED[albedo][RADII.index(radius)] - np.exp(-radius) / (4 * np.pi * radius**2)
    check(scattered, deviation, expected, error, f"ω = {albedo}, r = {radius}")
