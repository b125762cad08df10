"""Laws that need no table: exact for any medium (furnace, Beer–Lambert, refinement), at every lane width."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.analytic.scenes import agree
from tests.statistics import accept_squares, accept_z

from woodcock.film import Film
from woodcock.formats import read_grid
from woodcock.layout import module
from woodcock.scene import GridVolume

Box = dict[str, Any]
Grid = Callable[..., dict[str, Any]]
Picture = Callable[..., Film]
Agrees = Callable[[Film, Any], bool]


def noise(shape: tuple[int, int, int], seed: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).random(shape, dtype=np.float32)


def phases() -> list[dict[str, Any]]:
    return [{"kind": "isotropic"}, {"kind": "henyey_greenstein", "g": 0.8}, {"kind": "henyey_greenstein", "g": -0.99}]


@pytest.mark.parametrize("phase", phases(), ids=str)
@pytest.mark.parametrize("sigma_t", [1e-6, 1, 30, 300])
def test_white_furnace_of_a_constant_medium(box: Box, picture: Picture, lanes: int, sigma_t: float, phase: Any) -> None:
    """Nothing is absorbed and light comes from everywhere: every sample of every pixel is 1."""
    box["volumes"][0] |= {"sigma_t": sigma_t, "albedo": 1, "phase": phase}
    film = picture(box, 4, lanes)
    assert np.array_equal(film.mean, np.ones_like(film.mean))
    assert film.rejected == film.violations == 0


@pytest.mark.parametrize("phase", phases(), ids=str)
def test_white_furnace_of_a_grid(box: Box, grid: Grid, picture: Picture, lanes: int, phase: Any) -> None:
    box["volumes"] = [grid(noise((9, 6, 5)), scale=40, albedo=1, phase=phase)]
    film = picture(box, 4, lanes)
    assert np.array_equal(film.mean, np.ones_like(film.mean))
    assert film.rejected == film.violations == 0


@pytest.mark.parametrize("sigma_t", [0, 1e-6, 0.5, 6])
def test_beer_lambert_in_a_constant_medium(
    box: Box, picture: Picture, agrees: Agrees, lanes: int, sigma_t: float
) -> None:
    box["volumes"][0] |= {"sigma_t": sigma_t, "albedo": 0}
    film = picture(box, 256, lanes)
    if sigma_t > 1e-6:
        assert agrees(film, np.exp(-sigma_t))
    else:
        assert film.mean.mean() == pytest.approx(1, abs=1e-4)


def test_beer_lambert_through_a_grid_per_pixel(
    box: Box, grid: Grid, picture: Picture, agrees: Agrees, lanes: int
) -> None:
    """Against the optical depth of the float64 oracle's trilinear field, integrated by the midpoint rule."""
    volume = grid(noise((5, 4, 6)), scale=5, albedo=0)
    box |= {"volumes": [volume], "film": {"width": 16, "height": 16}}
    film = picture(box, 4096, lanes)
    described = GridVolume.model_validate(volume)
    x, y = np.meshgrid((np.arange(64) + 0.5) / 64, (np.arange(64) + 0.5) / 64)
    steps = 1000
    points = np.stack(np.broadcast_arrays(x[..., None], y[..., None], (np.arange(steps) + 0.5) / steps), -1)
    density = module("volume", "grid").density(described, read_grid(Path(described.file)), points)
    transmittance = np.exp(-density.mean(axis=-1)).reshape(16, 4, 16, 4).mean(axis=(1, 3))
    assert agrees(film, transmittance)
    z = (film.mean[..., 0] - transmittance) / np.sqrt(film.variance()[..., 0])
    accept_z(z, "of a pixel")
    accept_squares((z**2).sum(), z.size, "of pixels")


def test_constant_grid_equals_homogeneous_medium(box: Box, grid: Grid, picture: Picture, lanes: int) -> None:
    """A grid without null collisions takes the very same decisions as the homogeneous medium."""
    box["volumes"][0] |= {"sigma_t": 6, "albedo": 0.9}
    constant = picture(box, 64, lanes)
    box["volumes"] = [grid(np.full((4, 4, 4), 2, np.uint8), scale=3, albedo=0.9)]
    assert np.abs(picture(box, 64, lanes).mean - constant.mean).mean() < 1e-3


@pytest.mark.parametrize("exponent", [-40, -3, 0, 20, 40])
def test_scaling_lengths_and_coefficients_leaves_the_picture(box: Box, picture: Picture, exponent: int) -> None:
    """σ × k and size / k give the same picture, to the last bit for powers of two."""
    reference = picture(box, 8)
    k = 2.0**exponent
    box["volumes"][0] |= {"shape": {"kind": "box", "min": [0, 0, 0], "max": [1 / k] * 3}, "sigma_t": 2 * k}
    box["camera"] |= {"origin": [0.5 / k, 0.5 / k, -1 / k], "target": [0.5 / k] * 3, "height": 1 / k}
    assert np.array_equal(picture(box, 8).mean, reference.mean)


@pytest.mark.parametrize("strength", [1e-20, 1e20])
def test_radiance_scales(box: Box, picture: Picture, strength: float) -> None:
    reference = picture(box, 8)
    box["lights"][0]["radiance"] = strength
    film = picture(box, 8)
    assert np.allclose(film.mean, reference.mean * strength, rtol=1e-6, atol=0)
    assert np.allclose(film.m2, reference.m2 * strength**2, rtol=1e-5, atol=0)


def test_camera_a_million_box_sizes_away(box: Box, picture: Picture, agrees: Agrees) -> None:
    """Rays are anchored near the medium, so that nothing is lost to distance."""
    box["camera"] = {"kind": "perspective", "origin": [0.5, 0.5, -1e6], "target": [0.5, 0.5, 0.5], "up": [0, -1, 0]}
    box["camera"]["fov"] = float(np.degrees(2 * np.arctan(0.25 / 1e6)))
    box["volumes"][0] |= {"sigma_t": 1, "albedo": 0}
    film = picture(box, 256)
    assert agrees(film, np.exp(-1))


def test_superposition_of_lights(box: Box, picture: Picture) -> None:
    sun = {"kind": "directional", "direction": [1, 1, 1], "irradiance": 2}
    other = {"kind": "directional", "direction": [-1, 0.2, 0.1], "irradiance": 5}
    sky = {"kind": "constant", "radiance": 0.5}
    films = []
    for seed, lights in enumerate(([sun, other, sky], [sun], [other], [sky])):
        films.append(picture(box | {"lights": lights, "seed": seed}, 128))
    whole, *parts = films
    agree((1, whole), *((-1, part) for part in parts), within=0.005)
