"""Isothermal furnace: where media, walls and what lies behind them all have source function B, so has every pixel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.analytic.scenes import (
    PHASES,
    Grid,
    Kind,
    Picture,
    Scene,
    agree,
    ball,
    constant,
    cube_mesh,
    cuboid,
    noise,
    random_walk,
)

from woodcock.emission import blackbody
from woodcock.scene import BlackbodyEmission

HOT: Kind = {"kind": "blackbody", "kelvin": 3000, "reference": 2500, "luminance": 1}
#: (3,): what the black body shines with, linear Rec. 709.
B = blackbody.radiance(BlackbodyEmission(**HOT), np.array(3000.0))
WALL: Kind = {**ball(radius=3), "material": {"kind": "emissive", "radiance": B.tolist(), "two_sided": True}}
SKY: Kind = {"kind": "constant", "radiance": B.tolist()}


def hot_grid(grid: Grid, folder: Path, density: np.ndarray, **keys: object) -> Kind:
    """Of one temperature, whatever its density and albedo."""
    temperature = folder / f"kelvin{len(list(folder.iterdir()))}.npy"
    np.save(temperature, np.full((2, 3, 4), 1500, np.float32))
    return grid(density, emission=HOT | {"kelvin": 2, "file": str(temperature), "grid": "density"}, **keys)


@pytest.mark.parametrize("walls", ["sky", "wall"])
def test_of_everything(box: Scene, grid: Grid, tmp_path: Path, picture: Picture, walls: str) -> None:
    """Extinction, albedo and emission in colour, grids of all three, and surfaces that absorb nothing or shine."""
    albedos = tmp_path / "albedos.npy"
    np.save(albedos, noise(3, 4, 2, 3))
    surfaces = [
        {**ball((0.7, 0.6, 0.4), 0.2), "material": {"kind": "diffuse", "reflectance": 1}},
        {**ball((0.2, 0.3, 0.4), 0.15), "material": {"kind": "emissive", "radiance": B.tolist()}},
        {**ball((0.5, 0.5, 0.5), 1.5), "material": {"kind": "null"}},
    ]
    box |= {
        "volumes": [
            constant(ball(), [0.5, 1, 2], [0.9, 0.5, 0], emission=HOT, phase=PHASES["henyey_greenstein"]),
            constant({"kind": "mesh", "file": cube_mesh(tmp_path)}, 1, [0.1, 0.5, 1], emission=HOT),
            hot_grid(grid, tmp_path, noise(4, 3, 5, 3), scale=2, albedo=0.9, albedo_grid={"file": str(albedos)}),
            hot_grid(grid, tmp_path, noise(3, 3, 3), scale=2, albedo=0.5, interpolation="nearest"),
        ],
        "surfaces": surfaces if walls == "sky" else [*surfaces, WALL],
        "lights": [SKY] if walls == "sky" else [],
    }
    agree((1, picture(box, 128)), expected=B)


@pytest.mark.slow
@pytest.mark.parametrize("sigma_t", [1e-6, 1e-3, 1, [0.1, 1, 10], 100, 1e6], ids=str)
@pytest.mark.parametrize("albedo", [0, 0.5, [0.2, 0.99, 0]], ids=str)
def test_of_a_constant_medium(box: Scene, picture: Picture, sigma_t: object, albedo: object) -> None:
    box |= {"volumes": [constant(ball(), sigma_t, albedo, emission=HOT)], "lights": [SKY]}
    agree((1, picture(random_walk(box), 512)), expected=B)


@pytest.mark.slow
@pytest.mark.parametrize("majorant", [{"kind": "global"}, {"kind": "grid", "resolution": 7}], ids=str)
@pytest.mark.parametrize("scale", [1e-6, 1, 100, [0.1, 1, 10]], ids=str)
@pytest.mark.parametrize("interpolation", ["trilinear", "nearest"])
def test_of_a_grid(
    box: Scene, grid: Grid, tmp_path: Path, picture: Picture, scale: object, interpolation: str, majorant: Kind
) -> None:
    medium = hot_grid(grid, tmp_path, noise(5, 7, 3), scale=scale, albedo=0.6, interpolation=interpolation)
    box |= {"volumes": [medium], "lights": [SKY], "majorant": majorant}
    agree((1, picture(random_walk(box), 512)), expected=B)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["constant", "grid"])
def test_emission_is_that_of_the_absorption(
    box: Scene, grid: Grid, tmp_path: Path, picture: Picture, kind: str
) -> None:
    """ε = σ_a B given as a number or a grid of its own, not by a temperature."""
    density = noise(4, 5, 3)
    sigma, albedo, b = 3.0, 0.6, 0.7
    if kind == "constant":
        emission = {"kind": "constant", "epsilon": sigma * (1 - albedo) * b}
        medium = constant(cuboid(), sigma, albedo, emission=emission)
    else:
        file = tmp_path / "emission.npy"
        np.save(file, density)
        emission = {"kind": "grid", "file": str(file), "scale": sigma * (1 - albedo) * b}
        medium = grid(density, scale=sigma, albedo=albedo, emission=emission)
    box |= {"volumes": [medium], "lights": [SKY | {"radiance": b}]}
    agree((1, picture(box, 512)), expected=b)
