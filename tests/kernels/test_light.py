"""Lights against their float64 oracles: constant, directional, sun, point, spot; image in test_light_image.py."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.conftest import Rng
from tests.kernels.device_code import call
from tests.statistics import accept_counts, accept_mean

from woodcock.device import Context
from woodcock.layout import module
from woodcock.scene import ConstantLight, DirectionalLight, PointLight, SpotLight, SunLight
from woodcock.space import Space

SPACE = Space(np.array([0.5, -1, 2]), 2, 3)
INPUT = {"u": np.linspace(0, 1, 5, dtype=np.float32)}
SAMPLE = ["s.towards.x", "s.towards.y", "s.towards.z", "s.distance", "s.pdf"]


@pytest.mark.parametrize(
    ("kind", "attributes"),
    [
        ("constant", (True, False, False)),
        ("image", (True, True, False)),
        ("directional", (False, True, False)),
        ("sun", (True, True, False)),
        ("point", (False, True, True)),
        ("spot", (False, True, True)),
    ],
)
def test_what_estimates_it(kind: str, attributes: tuple[bool, bool, bool]) -> None:
    """Every light is found by one estimator at least; only those with a place have a position."""
    light = module("light", kind)
    assert attributes == (light.ON_ESCAPE, light.SAMPLED, light.LOCAL)
    assert hasattr(light, "position") == light.LOCAL


def test_constant(context: Context, lanes: int) -> None:
    light = ConstantLight(radiance=2.5)
    kind = module("light", "constant")
    expression = "light_constant_radiance(kind, vector_of(u, u, u))"
    got = call(context, "light", light, kind.record(light, SPACE), "", [expression], INPUT, lanes)
    assert np.array_equal(got[0] * 8, kind.radiance(light, np.zeros((5, 3)))[:, 0])


def test_directional(context: Context, lanes: int) -> None:
    light = DirectionalLight(direction=(3, -4, 12), irradiance=7)
    kind = module("light", "directional")
    body = "spectrum weight; vector d = light_directional_sample(kind, &weight);"
    got = call(context, "light", light, kind.record(light, SPACE), body, ["d.x", "d.y", "d.z", "weight"], INPUT, lanes)
    assert np.allclose(got[:3].T, kind.towards(light), atol=1e-7)
    assert np.allclose(kind.towards(light), np.array([-3, 4, -12]) / 13)
    assert np.array_equal(got[3] * 8, np.full(5, 7))


@pytest.mark.parametrize("radius", [0.001, 0.2665, 60])
def test_sun_samples(context: Context, lanes: int, radius: float, rng: Rng) -> None:
    """Samples fill the disk evenly in solid angle, and the weight is radiance over density."""
    light, kind, n = (
        SunLight(direction=(3, -4, 12), irradiance=7, angular_radius=radius),
        module("light", "sun"),
        1 << 14,
    )
    u, v = rng(6).random((2, n), dtype=np.float32)
    body = "light_sample s; light_sun_sample(kind, vector_of(u, u, u), u, v, &s);"
    got = call(
        context, "light", light, kind.record(light, SPACE), body, [*SAMPLE, "s.weight"], {"u": u, "v": v}, lanes
    ).astype(float)
    towards, distance, pdf, weight = got[:3], got[3], got[4], got[5] * 8
    assert np.allclose(np.linalg.norm(towards, axis=0), 1, atol=3e-7)
    assert (distance == np.float32(1e30)).all()

    alpha = np.radians(radius)
    solid_angle = 2 * np.pi * (2 * np.sin(alpha / 2) ** 2)
    assert np.allclose(pdf, 1 / solid_angle, rtol=1e-6)
    assert np.allclose(weight * pdf, kind.strength(light), rtol=1e-6)
    # On a surface that faces the middle the samples add up to the irradiance.
    middle = kind.towards(light)
    accept_mean(weight * (middle @ towards), 7, "irradiance", allowed=7e-6)

    # Float32 directions are off by 6e-8, which the smallest disk sees enlarged: two bins fewer at its edge.
    versine = ((towards - middle[:, None]) ** 2).sum(axis=0) / 2 / (solid_angle / (2 * np.pi))
    assert versine.max() < 1 + 2e-7 / alpha
    accept_counts(np.histogram(versine.clip(0, 1), bins=16, range=(0, 1))[0], what="versine")
    across = np.cross(middle, [0, 0, 1]) / np.linalg.norm(np.cross(middle, [0, 0, 1]))
    azimuth = np.arctan2(np.cross(middle, across) @ towards, across @ towards)
    accept_counts(np.histogram(azimuth, bins=16, range=(-np.pi, np.pi))[0], what="azimuth")


@pytest.mark.parametrize("radius", [0.001, 0.2665, 60])
def test_sun_disk(context: Context, lanes: int, radius: float) -> None:
    """Radiance and density of directions from the middle to twice the radius, and of the opposite one."""
    light, kind = SunLight(direction=(3, -4, 12), irradiance=7, angular_radius=radius), module("light", "sun")
    middle = kind.towards(light)
    side = np.cross(middle, [0, 0, 1]) / np.linalg.norm(np.cross(middle, [0, 0, 1]))
    angle = np.radians(radius) * np.array([0, 0.5, 0.98, 1.02, 1.5, 2, np.pi / np.radians(radius)])
    d = (np.cos(angle)[:, None] * middle + np.sin(angle)[:, None] * side).astype(np.float32)
    arguments = "kind, vector_of(x, y, z)"
    expressions = [f"light_sun_radiance({arguments})", f"light_sun_pdf({arguments})"]
    inputs = {name: np.ascontiguousarray(d[:, i]) for i, name in enumerate("xyz")}
    got = call(context, "light", light, kind.record(light, SPACE), "", expressions, inputs, lanes)
    inside = angle < np.radians(radius)
    exact = np.cos(angle)[:, None] * middle + np.sin(angle)[:, None] * side
    assert np.array_equal(kind.radiance(light, exact)[:, 0] > 0, inside)
    assert np.allclose(got[0] * 8.0, kind.radiance(light, exact)[:, 0], rtol=1e-6)
    assert np.array_equal(got[1] > 0, inside)


def test_sun_radiance_is_that_of_its_irradiance() -> None:
    """∫ L cos θ dω over the disk, by quadrature."""
    light = SunLight(direction=(0, 0, -1), irradiance=3, angular_radius=40)
    theta = (np.arange(2000) + 0.5) / 2000 * np.pi / 2
    direction = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=-1)
    radiance = module("light", "sun").radiance(light, direction)[:, 0]
    assert np.sum(radiance * np.cos(theta) * 2 * np.pi * np.sin(theta)) * np.pi / 4000 == pytest.approx(3, rel=2e-3)


LOCAL_LIGHTS = [
    PointLight(position=(0.3, 1, -2), intensity=5),
    SpotLight(position=(0.3, 1, -2), target=(1, 0, 3), intensity=5, cutoff=80),
    SpotLight(position=(0.3, 1, -2), target=(1, 0, 3), intensity=5, cutoff=30, beam=0),
    SpotLight(position=(0.3, 1, -2), target=(1, 0, 3), intensity=5, cutoff=30, beam=29.99),
    SpotLight(position=(0.3, 1, -2), target=(1, 0, 3), intensity=5, cutoff=0.01),
]


@pytest.mark.parametrize("light", LOCAL_LIGHTS, ids=repr)
def test_point_and_spot(context: Context, lanes: int, light: Any) -> None:
    """Weights at points all around, and in a narrow cone, are intensity × falloff / distance² in the device's units."""
    kind = module("light", light.kind)
    random = np.random.default_rng(7)
    target = np.array(getattr(light, "target", (1, 0, 3)))
    narrow = np.radians(getattr(light, "cutoff", 20)) * 3 * random.standard_normal((128, 3))
    points = np.concatenate([3 * random.standard_normal((128, 3)), target + narrow])
    local = np.array([SPACE.point(p) for p in points]).astype(np.float32)
    exact = local.astype(float) * 4 + SPACE.centre
    body = f"light_sample s; light_{light.kind}_sample(kind, vector_of(x, y, z), x, y, &s);"
    inputs = {name: np.ascontiguousarray(local[:, i]) for i, name in enumerate("xyz")}
    got = call(context, "light", light, kind.record(light, SPACE), body, [*SAMPLE, "s.weight"], inputs, lanes)
    to = kind.position(light) - exact
    distance = np.linalg.norm(to, axis=1)
    assert np.allclose(got[:3].T, to / distance[:, None], atol=1e-6)
    assert np.allclose(got[3] * 4, distance, rtol=1e-6)
    assert (got[4] == 0).all()
    # The slope of the falloff makes the most of what float32 directions are off by.
    steepness = kind.record(light, SPACE).get("steepness", 0) * np.sqrt(2 * kind.record(light, SPACE).get("cutoff", 0))
    scale = 5 / distance**2
    off = np.abs(got[5] * 8.0 - kind.weight(light, exact)[:, 0]) / scale
    settled = off < 1e-6 + 3e-7 * min(steepness, 1e5)
    assert settled.all()
    if light.kind == "spot":
        assert (got[5] == 0).any()
        assert (got[5] > 0).any()


def test_extremes_are_finite(context: Context, lanes: int) -> None:
    """A vertex in the light itself, and a beam that ends where the cone does but for rounding."""
    sharp = SpotLight(position=(1, 2, 3), target=(1, 0, 3), intensity=5, cutoff=30, beam=29.999999999999996)
    for light in (LOCAL_LIGHTS[0], sharp):
        kind = module("light", light.kind)
        body = f"""vector at = vector_uniform(kind->position);
        light_sample s; light_{light.kind}_sample(kind, at, u, u, &s);"""
        got = call(context, "light", light, kind.record(light, SPACE), body, [*SAMPLE, "s.weight"], INPUT, lanes)
        assert np.isfinite(got).all()


def test_intensities_in_other_units_give_the_same_picture() -> None:
    """Intensity is radiance × area: twice the lengths need four times as much."""
    small, large = Space(length_exponent=-3, radiance_exponent=2), Space(length_exponent=-2, radiance_exponent=2)
    for light in LOCAL_LIGHTS[:2]:
        kind = module("light", light.kind)
        brighter = light.model_copy(update={"intensity": 20})
        assert np.array_equal(kind.record(light, small)["intensity"], kind.record(brighter, large)["intensity"])


@pytest.mark.parametrize("cutoff", [3, 30, 60, 89])
def test_a_spots_span_is_where_its_light_is(context: Context, lanes: int, rng: Rng, cutoff: float) -> None:
    """Rays and points on them by chance: those in the span are in the cone, and no other."""
    kind, length, count = module("light", "spot"), 3.0, 4096
    light = SpotLight(position=(0.1, 0.2, -0.1), target=(0.4, 0.9, 0.3), intensity=1, cutoff=cutoff)
    random = rng(11)
    origin, direction = random.uniform(-1, 1, (count, 3)), random.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    inputs = {f"o{axis}": origin[:, i].astype(np.float32) for i, axis in enumerate("xyz")}
    inputs |= {f"d{axis}": direction[:, i].astype(np.float32) for i, axis in enumerate("xyz")}
    body = f"""vector o = vector_of(ox, oy, oz), d = vector_of(dx, dy, dz);
    real near = (real)0.f, far = (real){length}f;
    light_spot_span(kind, o, d, &near, &far);"""
    near, far = call(context, "light", light, kind.record(light, Space()), body, ["near", "far"], inputs, lanes)
    t = random.uniform(0, length, count)
    x = origin + t[:, None] * direction - np.array(light.position)
    lit = x @ kind.axis(light) > np.cos(np.radians(cutoff)) * np.linalg.norm(x, axis=1)
    # Rounding moves the ends; where they lie between is not known to 1e-3.
    sure = np.minimum(abs(t - near), abs(t - far)) > 1e-3
    assert sure.mean() > 0.99
    assert np.array_equal(lit[sure], ((near <= t) & (t <= far))[sure])
    assert 0 < lit.sum() < count
