"""Plane slabs against published values (van de Hulst 1980; DISORT test set 3a; Chandrasekhar's H function)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from woodcock.film import Film

Picture = Callable[..., Film]
Agrees = Callable[[Film, Any], bool]
Grid = Callable[..., dict[str, Any]]

WIDE = 2000.0


def relative_error(film: Film) -> float:
    """Standard error of the picture's mean: what makes agreement mean something."""
    return float(np.sqrt(film.variance().sum()) / film.mean.size / film.mean.mean())


def slab(mu: float, thickness: float, volume: dict[str, Any], light: dict[str, Any]) -> dict[str, Any]:
    """A slab of σ_t = 1 under z = 0, seen from above by parallel rays that leave it upwards at cosine mu."""
    sine = np.sqrt(1 - mu * mu)
    return {
        "camera": {
            "kind": "orthographic",
            "origin": [10 * sine, 0, 10 * mu],
            "target": [0, 0, 0],
            "up": [0, 1, 0],
            "height": 1e-3,
        },
        "volumes": [
            {
                "kind": "constant",
                "shape": {"kind": "box", "min": [-WIDE, -WIDE, -thickness], "max": [WIDE, WIDE, 0]},
                "sigma_t": 1,
                **volume,
            }
        ],
        "lights": [light],
        "film": {"width": 32, "height": 32},
        "seed": 11,
    }


DISORT_3A = pytest.mark.parametrize(("mu", "radiance"), [(0.1, 0.151159), (0.5, 0.101103), (1, 0.0395460)])
FORWARD = {"albedo": 1, "phase": {"kind": "henyey_greenstein", "g": 0.75}}
BEAM = {"kind": "directional", "direction": [0, 0, -1], "irradiance": np.pi}


@DISORT_3A
def test_disort_3a(mu: float, radiance: float, picture: Picture, agrees: Agrees) -> None:
    """Henyey–Greenstein .75, τ = 1, ω = 1, flux π from straight above: radiance leaving upwards."""
    film = picture(slab(mu, 1, FORWARD, BEAM), 1024)
    assert agrees(film, radiance)
    assert relative_error(film) < 0.006


@DISORT_3A
def test_disort_3a_as_a_grid(mu: float, radiance: float, picture: Picture, agrees: Agrees, grid: Grid) -> None:
    """A slab reflects by its optical depth alone, however the density is spread over its height."""
    density = np.random.default_rng(5).random((7, 1, 1), dtype=np.float32)
    scene = slab(mu, 1, FORWARD, BEAM)
    placed = [[2 * WIDE, 0, 0, -WIDE], [0, 2 * WIDE, 0, -WIDE], [0, 0, 1, -1], [0, 0, 0, 1]]
    scene["volumes"] = [grid(density, scale=float(1 / density.mean()), to_world=placed, **FORWARD)]
    film = picture(scene, 1024)
    assert agrees(film, radiance)
    assert relative_error(film) < 0.006


@pytest.mark.parametrize(
    ("omega", "mu", "albedo"),
    [
        (0.2, 0.1, 0.082660),
        (0.2, 0.5, 0.050855),
        (0.2, 1, 0.035231),
        (0.5, 0.1, 0.241721),
        (0.5, 0.5, 0.160144),
        (0.5, 1, 0.115226),
        (0.9, 0.1, 0.629336),
        (0.9, 0.5, 0.507939),
        (0.9, 1, 0.414947),
        (0.99, 0.1, 0.877512),
        (0.99, 0.5, 0.815140),
        (0.99, 1, 0.752721),
    ],
)
def test_chandrasekhar_half_space(omega: float, mu: float, albedo: float, picture: Picture, agrees: Agrees) -> None:
    """Isotropic, 60 mean free paths deep, under a uniform sky: radiance leaving is the plane albedo R(μ).

    At ω = .2 most of what is reflected has been through roulette.
    """
    film = picture(slab(mu, 60, {"albedo": omega}, {"kind": "constant", "radiance": 1}), 4096 if omega < 0.9 else 256)
    assert agrees(film, albedo)
    assert relative_error(film) < 0.002
