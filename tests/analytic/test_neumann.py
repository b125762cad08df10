"""The Neumann series: L = L⁰ + K L⁰ + K² L⁰ + …, each term a layer of the picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm
from tests.analytic.scenes import (
    PHASES,
    Grid,
    Kind,
    Picture,
    Scene,
    agree,
    ball,
    constant,
    cuboid,
    is_clean,
    noise,
    random_walk,
    rectangle,
    white_image,
)
from tests.statistics import accept

LIGHTS: list[Kind] = [
    {"kind": "constant", "radiance": 1},
    {"kind": "directional", "direction": [1, 0.5, 0.7], "irradiance": [1, 2, 3]},
    {"kind": "point", "position": [1.4, 1.2, -0.4], "intensity": 2},
]


def layers(film: Any) -> dict[str, np.ndarray]:
    return {layer: film.layer(layer).mean for layer in film.layers}


@pytest.mark.parametrize(
    "orders", [3, pytest.param(0, marks=pytest.mark.slow), pytest.param(16, marks=pytest.mark.slow)]
)
def test_orders_sum_to_the_beauty(box: Scene, grid: Grid, tmp_path: Path, picture: Picture, orders: int) -> None:
    """To rounding, sample by sample: every gain of a path goes to just one of them."""
    box |= {
        "volumes": [
            constant(ball(), [1, 2, 3], 0.9, phase=PHASES["two_lobe"], emission={"kind": "constant", "epsilon": 0.3}),
            grid(noise(4, 5, 3), scale=3, albedo=[0.9, 0.7, 0.5]),
        ],
        "surfaces": [
            rectangle([0.6, 0, 0], [0, 0, 0.6], [0.5, 1, 0.5], {"kind": "diffuse", "reflectance": 0.8}),
            rectangle(
                [0.2, 0, 0], [0, 0.2, 0], [0.5, 0.5, 1.4], {"kind": "emissive", "radiance": 3, "two_sided": True}
            ),
            {**ball((0.2, 0.3, 0.3), 0.2), "material": {"kind": "dielectric"}},
        ],
        "lights": [*LIGHTS, white_image(tmp_path)],
        "orders": orders,
    }
    film = picture(box, 16)
    assert is_clean(film)
    found = layers(film)
    beauty = found.pop("")
    assert list(found) == [*(f"order.{n}" for n in range(orders + 1)), "order.rest"]
    assert np.allclose(sum(found.values()), beauty, rtol=1e-5, atol=1e-6)
    assert all(layer.max() > 0 for layer in list(found.values())[:4])


@pytest.mark.parametrize(
    "kind", ["constant", pytest.param("grid", marks=pytest.mark.slow), pytest.param("coloured", marks=pytest.mark.slow)]
)
def test_order_0_is_what_does_not_scatter(box: Scene, grid: Grid, picture: Picture, kind: str) -> None:
    """The same random numbers decide where flights end, whether they then scatter or not."""

    def medium(albedo: float) -> Kind:
        match kind:
            case "grid":
                return grid(noise(4, 5, 3), scale=4, albedo=albedo)
            case "coloured":
                return constant(cuboid(), [1, 2, 4], albedo)
            case _:
                return constant(cuboid(), 2, albedo)

    box |= {"lights": LIGHTS[:1], "orders": 1}
    scattering, absorbing = (picture(random_walk(box, volumes=[medium(albedo)]), 64) for albedo in (0.8, 0))
    assert np.array_equal(scattering.layer("order.0").mean, absorbing.layer("").mean)
    assert np.all(absorbing.layer("order.1").mean == 0)


def test_orders_of_a_thin_medium(box: Scene, picture: Picture) -> None:
    """A slab seen along its normal under a sky of 1: ω τ is scattered once, as hardly anything is lost to be scattered
    again; what is falls with ω² τ² times a logarithm of τ, for rays along the slab are long.
    """
    tau, omega = 1e-3, 0.5
    slab = {"kind": "box", "min": [-50, -50, 0], "max": [51, 51, 1]}
    scene = random_walk(box, volumes=[constant(slab, tau, omega)], lights=LIGHTS[:1], orders=2)
    film = picture(scene, 1 << 14)
    agree((1, film.layer("order.0")), expected=np.exp(-tau), within=1e-4)
    once, twice = film.layer("order.1"), film.layer("order.2")
    agree((1, once), expected=omega * tau, within=0.02)
    assert 0 < twice.mean.mean() < 10 * (omega * tau) ** 2


@pytest.mark.parametrize("albedo", [0.5, pytest.param(0.99, marks=pytest.mark.slow)])
def test_the_remainder_is_bounded(box: Scene, picture: Picture, albedo: float) -> None:
    """‖K‖ = ω (1 - e^-τ) with τ of the longest way through: what is left after order n is below ‖K‖ⁿ⁺¹ / (1 - ‖K‖)."""
    sigma = 1.0
    bound = albedo * -np.expm1(-sigma * np.sqrt(3))
    orders = 4
    scene = random_walk(box, volumes=[constant(cuboid(), sigma, albedo)], lights=LIGHTS[:1], orders=orders)
    film = picture(scene, 1024)
    for n in range(orders + 1):
        term = film.layer(f"order.{n}")
        error = np.sqrt(term.variance().mean() / term.count.size)
        accept(norm.sf((term.mean.mean() - bound**n) / error), f"order {n}", exact=False)
    rest = film.layer("order.rest")
    assert 0 < rest.mean.mean() < bound ** (orders + 1) / (1 - bound)
