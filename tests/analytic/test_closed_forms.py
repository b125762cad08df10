"""Small scenes of the full loop whose radiance can be written down: one factor of a path's weight each."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.analytic.scenes import Grid, Kind, Picture, Scene, affine, agree, constant, random_walk, rectangle
from tests.statistics import accept_z

from woodcock.film import Film


def seen_from(scene: Scene, z: float) -> Scene:
    """The unit square of x and y seen along +z, by parallel rays from there."""
    camera = {"kind": "orthographic", "origin": [0.5, 0.5, z], "target": [0.5, 0.5, z + 1], "up": [0, -1, 0]}
    return scene | {"camera": camera | {"height": 1}}


def slab(low: float, high: float) -> list[list[float]]:
    """Where a grid's unit cube lies: between two z, and far to the sides."""
    return affine([60, 0, 0], [0, 60, 0], [0, 0, high - low], [-30, -30, low])


def board(low: float, high: float) -> Kind:
    return {"kind": "box", "min": [-30, -30, low], "max": [31, 31, high]}


def order(film: Film, name: str) -> Film:
    return film.layer(f"order.{name}")


@pytest.mark.parametrize("depth", [0.5, 5])
def test_a_wall_lit_through_a_grid(box: Scene, grid: Grid, picture: Picture, depth: float) -> None:
    """Straight view of Lambert's wall, in a beam from behind the camera that falls in at 60 degrees:
    ρ/π E cos θ exp(-τ / cos θ), all of it scattered once.

    Walks that lose more than nineteen twentieths play roulette; the cosine is that of the light, not of the view.
    """
    cosine, reflectance, irradiance = 0.5, 0.8, 3.0
    density = np.random.default_rng(6).random((9, 1, 1), dtype=np.float32)
    scene = random_walk(
        seen_from(box, 2),
        volumes=[grid(density, scale=float(depth * cosine / density.mean()), albedo=0.5, to_world=slab(0, 1))],
        surfaces=[rectangle([40, 0, 0], [0, 40, 0], [0.5, 0.5, 3], {"kind": "diffuse", "reflectance": reflectance})],
        lights=[{"kind": "directional", "direction": [3**0.5 / 2, 0, cosine], "irradiance": irradiance}],
        orders=1,
    )
    # Scattered once: what the wall sends into the grid may come back and be scattered again.
    film = picture(scene, 2048)
    assert np.all(order(film, "1").mean.max(axis=(0, 1)) > 0)  # or the light came from the other side
    agree((1, order(film, "1")), expected=reflectance / np.pi * irradiance * cosine * np.exp(-depth), within=0.01)
    assert np.all(order(film, "0").mean == 0)


def emitted(pieces: list[tuple[float, float, float]]) -> float:
    """∫ ε exp(-τ) through layers of (length, σ_t, ε), from the eye on."""
    total, left = 0.0, 1.0
    for length, sigma_t, epsilon in pieces:
        through = np.exp(-sigma_t * length)
        total += left * epsilon * (length if sigma_t == 0 else (1 - through) / sigma_t)
        left *= through
    return total


@pytest.mark.parametrize(("near", "far"), [(0, 1), (1, 2), (2, 3)])
def test_a_glow_before_and_behind_a_grid(box: Scene, grid: Grid, picture: Picture, near: float, far: float) -> None:
    """A black medium that shines, with a black grid in a part of it: its emission counts once in each part."""
    glow, sigma_t, dark = 2.0, 0.4, 0.9
    shining = constant(board(0, 3), sigma_t, 0, emission={"kind": "constant", "epsilon": glow})
    ones = grid(np.ones((2, 3, 2), np.uint8), scale=dark, albedo=0, to_world=slab(near, far))
    film = picture(random_walk(seen_from(box, -1), volumes=[shining, ones], lights=[]), 1024)
    inside = [(1.0, sigma_t + dark * (near <= z < far), glow) for z in range(3)]
    agree((1, film), expected=emitted(inside), within=0.002)


@pytest.mark.parametrize("free_flight", ["delta", "decomposition"])
@pytest.mark.parametrize("scale", [0.3, 8, [1, 0.2, 0.5], [20, 1, 4]])
def test_a_glow_that_varies(box: Scene, grid: Grid, picture: Picture, scale: Any, free_flight: str) -> None:
    """A black grid that shines more where it is thinner, also where it is empty, against a quadrature along the ray.
    Thin ones are gathered along flights, the others where these collide tentatively."""
    density, glow = np.random.default_rng(7).random((2, 9)).astype(np.float32)
    density[[2, 6]] = 0
    file = grid(glow[:, None, None])["file"]
    fire = grid(
        density[:, None, None], scale=scale, albedo=0, to_world=slab(0, 1), emission={"kind": "grid", "file": file}
    )
    film = picture(
        random_walk(seen_from(box, -1), volumes=[fire], lights=[], free_flight={"kind": free_flight}), 1 << 13
    )

    z = (np.arange(90000) + 0.5) / 90000
    tau = np.interp(z * 9 - 0.5, np.arange(9), density)[:, None] * np.atleast_1d(scale)
    tau = (np.cumsum(tau, axis=0) - tau / 2) / z.size
    expected = np.interp(z * 9 - 0.5, np.arange(9), glow) @ np.exp(-tau) / z.size
    agree((1, film), expected=expected, within=0.002)


@pytest.mark.parametrize("kind", ["constant", "grid"])
def test_media_scatter_by_their_share(box: Scene, grid: Grid, picture: Picture, kind: str) -> None:
    """The mean albedo of first collisions is Σ σ_s / Σ σ_t, for media of one place that differ in both."""
    media: list[tuple[float, Any]] = [(1.0, 0.9), (0.5, [0.1, 0.5, 1]), (1.5, 0)]
    box["volumes"] = [
        constant(board(0, 1), sigma_t, albedo)
        if kind == "constant"
        else grid(np.full((2, 2, 2), 3, np.uint8), scale=sigma_t / 3, albedo=albedo, to_world=slab(0, 1))
        for sigma_t, albedo in media
    ]
    film = picture(random_walk(seen_from(box, -1), lights=[], layers=["albedo"]), 1024)
    sigma_s = sum(sigma_t * np.broadcast_to(albedo, 3) for sigma_t, albedo in media)
    depth = sum(sigma_t for sigma_t, _ in media)
    accept_z(deviation(film, "albedo", sigma_s / depth * (1 - np.exp(-depth))))


def deviation(film: Film, name: str, expected: Any) -> Any:
    """A layer's mean off what is expected, in standard errors; of layers, films say no variance."""
    layer = film.layer(name)
    error = np.sqrt(layer.m2.sum(axis=(0, 1))) / layer.count.sum()
    return (layer.mean.mean(axis=(0, 1)) - expected) / error


def test_media_behind_each_other(box: Scene, picture: Picture) -> None:
    """First collisions in slabs [0, 1] and [2, 3], seen from z = -1: how many, and how deep."""
    slabs = [(0.0, 0.7), (2.0, 1.6)]
    box["volumes"] = [constant(board(low, low + 1), sigma_t, 1) for low, sigma_t in slabs]
    film = picture(random_walk(seen_from(box, -1), lights=[], layers=["albedo", "depth"]), 1024)
    through = np.exp([-sigma_t for _, sigma_t in slabs])
    # ∫ (1 + z) σ_t exp(-τ) dz over each
    inside = [(2 + low) * -t + (1 + low) + (1 - t) / s for (low, s), t in zip(slabs, through, strict=True)]
    accept_z(deviation(film, "albedo", 1 - through.prod()))
    accept_z(deviation(film, "depth", inside[0] + through[0] * inside[1]))


def test_a_fog_that_glows(box: Scene, picture: Picture) -> None:
    """In the midst of it the radiance is ε / σ_a, of which ωⁿ ε / σ_t has been scattered n times.

    Paths play roulette from their second vertex on.
    """
    sigma_t, albedo, epsilon = 2.0, np.array([0.2, 0.1, 0.04]), 3.0
    fog = constant(board(-60, 60), sigma_t, albedo.tolist(), emission={"kind": "constant", "epsilon": epsilon})
    film = picture(random_walk(seen_from(box, 0), volumes=[fog], lights=[], orders=2), 1024)
    for n in range(3):
        agree((1, order(film, str(n))), expected=albedo**n * epsilon / sigma_t, within=0.02)
    agree((1, film.layer("")), expected=epsilon / sigma_t / (1 - albedo), within=0.002)
