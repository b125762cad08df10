"""The integrator `emission_absorption`: L′ + σ_t L = ε, against scipy's Radau and closed forms, of any stiffness."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from tests.kernels.ray_oracles import Gridded, Homogeneous, Media, emitted, optical_depth, pieces
from tests.kernels.rays import launch, trace
from tests.kernels.test_transmittance import ANISOTROPIC, SHAPE, crossing

from woodcock.deterministic import lanes_of
from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.film import LUMINANCE
from woodcock.formats import Grid
from woodcock.integrator import emission_absorption
from woodcock.scene import BoxShape, SphereShape, parse

CUBE = BoxShape(min=(0, 0, 0), max=(1, 1, 1))
#: Along z through the unit cube.
THROUGH = np.array([[0.5, 0.25, -1, 0, 0, 1]], np.float32)
#: Relative error that is left to Radau itself.
RADAU = 1e-7
PARTS = ["core/precision_double.h", "core/exponential.h"]


def values(seed: int, shape: tuple[int, ...] = SHAPE) -> Any:
    return np.random.default_rng(seed).random(shape).astype(np.float32)


def crossing_few() -> Any:
    """Rays from outside, from inside, along planes and faces, and through a corner."""
    return crossing(ANISOTROPIC, SHAPE)[[0, 3, 12, 20, 40, 46]]


# One step


def test_moments_of_the_exponential(context: Context, lanes: int) -> None:
    """∫₀¹ exp(-z u) uᵏ du to 14 digits at any z, against adaptive quadrature, and its limits where that fails."""
    z = np.array([0, 1e-300, 1e-30, 1e-9, 0.1, 0.9, 1.999, 2, 2.5, 7, 40, 699, 1e6, 1e30, 1e150])
    got = evaluate(
        context,
        [f"moment[{k}]" for k in range(5)],
        {"z": z},
        lanes=lanes_of(lanes, precise=True),
        parts=PARTS,
        body="real moment[5];\nexponential_moments(z, moment);",
    )
    for k, found in enumerate(got):
        for at, moment in zip(z, found, strict=True):
            if at > 600:
                right = [1.0, 1.0, 2.0, 6.0, 24.0][k] / at / at**k if at < 1e60 or k == 0 else 0.0
            else:
                right = quad(lambda u, at=at, k=k: np.exp(-at * u) * u**k, 0, 1, epsabs=0, epsrel=1e-13)[0]
            assert moment == pytest.approx(right, rel=3e-14, abs=1e-290)


def test_a_step_is_exact_for_what_it_is_made_for(context: Context, lanes: int) -> None:
    """ε of fourth degree over a constant σ of any stiffness; ε in proportion to a σ of fourth degree."""
    sigma = np.array([0, 1e-30, 1e-3, 1, 30, 700, 1e8])
    body = """
    real sigma_[5], epsilon[5], gain, error, gain_b, error_b, flat[5], z;
    mask resolved, resolved_b;
    for (int j = 0; j < 5; ++j) {
        real u = (real)exponential_node[j];
        flat[j] = s;
        epsilon[j] = 1.f + u * (2.f + u * (u - 3.f));
    }
    z = exponential_step(flat, epsilon, (real)0.5f, &gain, &error, &resolved);
    for (int j = 0; j < 5; ++j) sigma_[j] = s * epsilon[j];
    for (int j = 0; j < 5; ++j) epsilon[j] = sigma_[j] * 7.f;
    z = exponential_step(sigma_, epsilon, (real)0.0625f, &gain_b, &error_b, &resolved_b);
    """
    gain, proportional, depth = evaluate(
        context, ["gain", "gain_b", "z"], {"s": sigma}, lanes=lanes_of(lanes, precise=True), parts=PARTS, body=body
    )
    for s, found in zip(sigma, gain, strict=True):
        points = None if s < 1 else [1 / s, 40 / s]
        right = quad(
            lambda u, s=s: (1 + u * (2 + u * (u - 3))) * np.exp(-s * u / 2) / 2,
            0,
            1,
            epsrel=1e-12,
            epsabs=0,
            points=points,
        )[0]
        assert found == pytest.approx(1 / s if s > 1e6 else right, rel=1e-7 if s > 1e6 else 2e-13)
    assert np.allclose(depth, 0.0625 * 1.25 * sigma, rtol=1e-14, atol=0)
    assert np.allclose(proportional, -7 * np.expm1(-depth), rtol=1e-14, atol=0)


# Rays


@pytest.mark.parametrize("thickness", [1e-8, 1.0, 30.0, 1e4])
def test_it_converges_to_radau(context: Context, thickness: float) -> None:
    """Within the bound, and the bound within the tolerance; with light behind."""
    media: Media = [Gridded(values(40), ANISOTROPIC, thickness, 3.0 * thickness)]
    rays = crossing_few()
    right = np.array([emitted(media, ray, 0.5) for ray in rays])
    for tolerance in (1e-2, 1e-4, 1e-6):
        film = trace(context, "emission_absorption", media, rays, lanes=4, tolerance=tolerance, radiance=0.5)
        off, bound = np.abs(film.mean[0, :, 0] - right), film.bound
        assert film.rejected == 0
        assert bound is not None
        assert np.all(off <= bound[0, :, 0] + RADAU * right)
        assert np.all(bound[0, :, 0] <= tolerance * right)


def test_a_bound_holds_for_every_ray(context: Context) -> None:
    """Thousands of rays against a tolerance of a millionth: an estimate that agreed by chance would show."""
    rays = crossing(ANISOTROPIC, SHAPE, 3000)
    for thickness in (3.0, 100.0, 3e3):
        media: Media = [Gridded(values(40), ANISOTROPIC, thickness, 3.0 * thickness)]
        right, film = (trace(context, "emission_absorption", media, rays, lanes=4, tolerance=t) for t in (1e-6, 1e-2))
        assert film.bound is not None
        assert right.bound is not None
        assert np.all(np.abs(film.mean - right.mean) <= film.bound + right.bound)
        assert np.all(film.bound <= 1e-2 * film.mean)


@pytest.mark.parametrize("precise", [True, False])
def test_every_width_gives_the_same(context: Context, lanes: int, precise: bool) -> None:
    media: Media = [Gridded(values(40), ANISOTROPIC, 5.0, 3.0)]
    rays = crossing(ANISOTROPIC, SHAPE)
    keys: dict[str, Any] = {"precise": precise, "tolerance": 1e-3}
    one = trace(context, "emission_absorption", media, rays, lanes=1, **keys)
    film = trace(context, "emission_absorption", media, rays, lanes=lanes, **keys)
    assert np.allclose(film.mean, one.mean, rtol=1e-12 if precise else 2e-5, atol=0)
    assert np.allclose(film.bound, one.bound, rtol=1e-2, atol=1e-4)


def test_floats_stay_within_their_bound(context: Context) -> None:
    media: Media = [Gridded(values(40), ANISOTROPIC, 30.0, 90.0)]
    rays = crossing(ANISOTROPIC, SHAPE)
    right = trace(context, "emission_absorption", media, rays, lanes=4, tolerance=1e-6)
    film = trace(context, "emission_absorption", media, rays, lanes=4, precise=False, tolerance=1e-3)
    assert film.bound is not None
    assert right.bound is not None
    assert np.all(np.abs(film.mean - right.mean) <= film.bound + right.bound)
    assert np.all(film.bound <= 1.1e-3 * film.mean)


@pytest.mark.parametrize("precise", [True, False])
def test_isothermal_law_in_a_slab(context: Context, lanes: int, precise: bool) -> None:
    """L = B (1 - exp(-τ)), by expm1, from τ = 1e-30 to 1e30."""
    for depth in (1e-30, 1e-8, 1e-3, 1.0, 20.0, 87.0, 1e8, 1e30):
        media: Media = [Homogeneous(CUBE, depth, 2 * depth)]
        film = trace(context, "emission_absorption", media, THROUGH, lanes=lanes, precise=precise, radiance=0.0)
        assert film.rejected == 0
        assert film.mean[0, 0, 0] == pytest.approx(-2 * np.expm1(-depth), rel=1e-7 if precise else 1e-5)
        assert film.bound is not None
        assert abs(film.mean[0, 0, 0] + 2 * np.expm1(-depth)) <= film.bound[0, 0, 0]
        assert film.bound[0, 0, 0] <= (1e-7 if precise else 2e-5) * film.mean[0, 0, 0] + 1e-43


@pytest.mark.parametrize("thickness", [1e-12, 1.0, 1e3, 1e9, 1e30])
def test_isothermal_law_in_a_grid(context: Context, thickness: float) -> None:
    """The same where σ_t varies: ε = B σ_t, and the same radiance behind, is an isothermal furnace."""
    rays = crossing(ANISOTROPIC, SHAPE)
    medium = Gridded(values(41), ANISOTROPIC, thickness, 4 * thickness, isothermal=True)
    film = trace(context, "emission_absorption", [medium], rays, lanes=4, radiance=4.0)
    assert np.allclose(film.mean, 4, rtol=1e-12, atol=0)
    film = trace(context, "emission_absorption", [medium], rays, lanes=4, radiance=0.0)
    right = np.array([-4 * np.expm1(-optical_depth([medium], ray)[0]) for ray in rays])
    assert np.allclose(film.mean[0, :, 0], right, rtol=1e-12, atol=1e-45)


@pytest.mark.parametrize("thickness", [1e10, 1e20, 1e30])
def test_stiff_media_show_their_surface(context: Context, thickness: float) -> None:
    """L tends to ε / σ_t where the ray enters, also where σ_t falls or rises by orders from there."""
    grid = values(42)
    grid[grid < 0.3] *= 1e-3
    rays = crossing(ANISOTROPIC, SHAPE, 200)
    medium = Gridded(grid, ANISOTROPIC, thickness, 2 * thickness)
    film = trace(context, "emission_absorption", [medium], rays, lanes=4)
    met = [(index, pieces([medium], ray)[0][0]) for index, ray in enumerate(rays) if len(pieces([medium], ray)[0])]
    at = np.stack([rays[index, :3] + t * rays[index, 3:].astype(float) for index, t in met])
    sigma, epsilon = medium.at(at)
    shown = film.mean[0, [index for index, _ in met], 0]
    assert film.rejected == 0
    assert np.allclose(shown, epsilon[:, 0] / sigma[:, 0], rtol=2e-4, atol=0)


def test_emission_without_absorption(context: Context) -> None:
    """σ_t = 0: L is the integral of ε, which is another medium's optical depth."""
    rays = crossing(ANISOTROPIC, SHAPE)
    glowing = Gridded(values(43), ANISOTROPIC, 0.0, 2.0, isothermal=True)
    film = trace(context, "emission_absorption", [glowing], rays, lanes=4, radiance=3.0)
    right = [3 + optical_depth([Gridded(glowing.values, ANISOTROPIC, 2.0)], ray)[0] for ray in rays]
    assert np.allclose(film.mean[0, :, 0], right, rtol=1e-12, atol=0)


def test_nothing_emitted_is_transmittance(context: Context) -> None:
    rays = crossing(ANISOTROPIC, SHAPE)
    media: Media = [Gridded(values(44), ANISOTROPIC, 9.0), Homogeneous(CUBE, 2.0)]
    film = trace(context, "emission_absorption", media, rays, lanes=4, radiance=3.0)
    right = [3 * np.exp(-optical_depth(media, ray)[0]) for ray in rays]
    assert np.allclose(film.mean[0, :, 0], right, rtol=1e-12, atol=0)


def test_overlapping_media_and_lattices_across_each_other(context: Context) -> None:
    """A ball in two grids, one of nearest voxels: ε and σ_t jump and have kinks in the middle of others' cells."""
    turned = np.array([[0.25, 0.125, 0, -1], [-0.5, 0.25, 0, -2], [0, 0, 0.25, 0.25], [0, 0, 0, 1]])
    media: Media = [
        Gridded(values(45), ANISOTROPIC, 2.0, 3.0),
        Homogeneous(SphereShape(center=(0.5, -2, 0.75), radius=1), 1.5, 0.5),
        Gridded(values(46, (3, 7, 8)), turned, 3.0, 2.0, nearest=True),
    ]
    rays = crossing(ANISOTROPIC, SHAPE)[[1, 3, 13, 20]]
    right = np.array([emitted(media, ray, 1.0) for ray in rays])
    film = trace(context, "emission_absorption", media, rays, lanes=4, tolerance=1e-5)
    off, bound = np.abs(film.mean[0, :, 0] - right), film.bound
    assert bound is not None
    assert np.all(off <= bound[0, :, 0] + RADAU * right)
    assert np.all(bound[0, :, 0] <= 1e-5 * right)


def test_colours_are_solved_each_for_itself(context: Context) -> None:
    sigma, epsilon = np.array([0.5, 20.0, 0.0]), np.array([1.0, 5.0, 0.0])
    rays = crossing_few()
    film = trace(context, "emission_absorption", [Gridded(values(47), ANISOTROPIC, sigma, epsilon)], rays, lanes=4)
    for channel in range(3):
        grey = Gridded(values(47), ANISOTROPIC, sigma[channel], epsilon[channel])
        alone = trace(context, "emission_absorption", [grey], rays, lanes=4)
        assert np.allclose(film.mean[..., channel], alone.mean[..., 0], rtol=2e-4, atol=0)


# Scenes


def test_a_scene_of_fire(context: Context, lanes: int) -> None:
    """A flame's temperature on a grid of its own beside a glowing ball: the tolerance holds against a tighter one."""
    grids = {"density": values(48), "temperature": values(49, (9, 4, 5)), "glow": values(50, (3, 4, 5))}

    def read(file: str, name: str | None) -> Grid:
        found = grids[name or "density"]
        depth, height, width = found.shape
        return Grid(name or "density", found, np.diag([1 / width, 1 / height, 1 / depth, 1]), placed=False)

    ball = {"kind": "sphere", "center": [0.5, 0.5, 0.5], "radius": 0.4}
    fire = {"kind": "blackbody", "file": "x", "kelvin": 2500}
    glow = {"kind": "grid", "file": "x", "grid": "glow", "scale": [1, 2, 3]}
    scene: dict[str, Any] = {
        "camera": {"kind": "orthographic", "origin": [0.5, 0.5, -1], "target": [0.5, 0.5, 0.5], "height": 1.2},
        "volumes": [
            {"kind": "grid", "file": "x", "scale": 9, "albedo": 0.25, "emission": fire},
            {"kind": "grid", "file": "x", "scale": 2, "albedo": 0, "emission": glow},
            {
                "kind": "constant",
                "shape": ball,
                "sigma_t": 1,
                "albedo": 0,
                "emission": {"kind": "constant", "epsilon": 2},
            },
        ],
        "film": {"width": 5, "height": 4, "filter": {"kind": "gaussian"}},
    }
    films = []
    for tolerance in (1e-2, 1e-4):
        scene["integrator"] = {"kind": "emission_absorption", "tolerance": tolerance}
        layout = emission_absorption.lay_out(parse(json.dumps(scene)), read)
        films.append(launch(context, layout, (4, 5), lanes=lanes, precise=True, samples=(0, 2)))
        assert films[-1].bound is not None
        assert np.all(films[-1].bound <= tolerance * films[-1].mean + 1e-9)
    assert films[0].rejected == 0
    assert np.median(films[1].mean) > 0.1
    assert films[0].bound is not None
    assert np.all(np.abs(films[0].mean - films[1].mean) <= films[0].bound + films[1].bound)


def test_a_black_body_shines_as_it_is_defined_to(context: Context) -> None:
    """A slab of one temperature: L = (1 - ω) B (1 - exp(-τ)), and B has the luminance that the scene gives it."""
    glowing = {"kind": "blackbody", "kelvin": 5000, "reference": 5000, "luminance": 3}
    shape = {"kind": "box", "min": [0, 0, 0], "max": [2, 2, 2]}
    scene: dict[str, Any] = {
        "camera": {"kind": "orthographic", "origin": [1, 1, -1], "target": [1, 1, 0], "height": 1},
        "volumes": [{"kind": "constant", "shape": shape, "sigma_t": 0.75, "albedo": 0.25, "emission": glowing}],
        "film": {"width": 2, "height": 2},
    }
    layout = emission_absorption.lay_out(parse(json.dumps(scene)), lambda file, name: pytest.fail("there is no file"))
    film = launch(context, layout, (2, 2), lanes=4, precise=True, samples=(0, 1))
    assert np.allclose(film.mean @ LUMINANCE, -3 * 0.75 * np.expm1(-1.5), rtol=1e-4, atol=0)
