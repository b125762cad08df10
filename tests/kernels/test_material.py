"""Materials against their float64 oracles: diffuse, mirror, dielectric, rough_dielectric, emissive, null."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2
from tests.conftest import Rng
from tests.kernels.surface_code import Array, built, run, unit_vectors
from tests.statistics import accept, accept_mean

from woodcock.device import Context
from woodcock.layout import module
from woodcock.scene.surface import (
    DielectricMaterial,
    DiffuseMaterial,
    DiskSurface,
    EmissiveMaterial,
    MirrorMaterial,
    NullMaterial,
    RoughDielectricMaterial,
)

SAMPLE = """
vector out; spectrum weight, value; real pdf, density;
integer surface = word_as_integer(which);
material_sample(world, surface, in, shading, geometric, u, v, w, &out, &weight, &pdf);
material_eval(world, surface, in, out, shading, geometric, &value, &density);
"""
SAMPLED = ["out.x", "out.y", "out.z", "spectrum_channel(weight, 0)", "pdf", "spectrum_channel(value, 0)", "density"]
EVAL = """
spectrum value, seen; real density;
integer surface = word_as_integer(which);
material_eval(world, surface, in, out, shading, geometric, &value, &density);
seen = material_emission(world, surface, in, geometric);
"""

SCATTERING = [
    DiffuseMaterial(reflectance=0.7),
    RoughDielectricMaterial(ior=1.5, roughness=0.3),
    RoughDielectricMaterial(ior=1.5, roughness=0.05),
    RoughDielectricMaterial(ior=0.7, roughness=0.5),
    RoughDielectricMaterial(ior=2.5, roughness=1.0),
]
SMOOTH = [
    MirrorMaterial(reflectance=0.9),
    DielectricMaterial(ior=1.5),
    DielectricMaterial(ior=0.6),
    DielectricMaterial(ior=1.0),
    NullMaterial(),
    EmissiveMaterial(radiance=2.0),
]
EVERY = [*SCATTERING, *SMOOTH]
NORMAL = np.array([0.48, -0.6, 0.64])


def device(
    context: Context,
    lanes: int,
    body: str,
    results: list[str],
    material: int | Array,
    normal: Array = NORMAL,
    **inputs: Array,
) -> Array:
    """Every material in one program, so that the device compiles it once; `material` picks from EVERY."""
    world = built([DiskSurface(radius=1, material=one) for one in EVERY])
    n = len(next(iter(inputs.values())))
    normals = {"shading": np.broadcast_to(normal, (n, 3)), "geometric": np.broadcast_to(normal, (n, 3))}
    which = np.broadcast_to(np.asarray(material, np.uint32), n).copy()
    return run(context, world, lanes, body, results, which=which, **(normals | inputs)).astype(float)


def sampled(
    context: Context, lanes: int, material: int, into: Array, random: np.random.Generator, **more: Array
) -> Array:
    uniforms = dict(zip("uvw", random.random((3, len(into)), dtype=np.float32), strict=True))
    return device(context, lanes, SAMPLE, SAMPLED, material, **{"in": into}, **uniforms, **more)


def sphere(n: int) -> tuple[Array, float]:
    """Directions spread evenly, and the solid angle of each."""
    z = 1 - (2 * np.arange(n) + 1) / n
    azimuth = np.pi * (1 + np.sqrt(5)) * np.arange(n)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(azimuth), r * np.sin(azimuth), z], axis=1), 4 * np.pi / n


def at_angle(cosine: float) -> Array:
    """A direction of travel whose cosine to NORMAL is this."""
    across = np.cross(NORMAL, [0, 0, 1])
    across /= np.linalg.norm(across)
    return cosine * NORMAL + np.sqrt(1 - cosine**2) * across


def cells(v: Array) -> Array:
    """Which of 20 × 16 cells of the sphere around NORMAL directions lie in."""
    first = np.cross(NORMAL, [1.0, 0, 0])
    azimuth = np.arctan2(v @ np.cross(NORMAL, first), v @ first) / (2 * np.pi) + 0.5
    return np.minimum((v @ NORMAL + 1) * 10, 19).astype(int) * 16 + np.minimum(azimuth * 16, 15).astype(int)


@cache
def probabilities(index: int, cosine: float) -> Array:
    """Of samples to lie in each cell, by the oracle."""
    material = SCATTERING[index]
    grid, share = sphere(1 << 18)
    into, normal = (np.broadcast_to(v, grid.shape) for v in (at_angle(cosine), NORMAL))
    p = module("material", material.kind).density(material, into, grid, normal)
    return np.bincount(cells(grid), p * share, minlength=320)


@cache
def energy(index: int, cosine: float) -> float:
    """What comes back in light of radiance n² everywhere, over the ray's own n², by the oracle's integral."""
    material = SCATTERING[index]
    grid, share = sphere(1 << 18)
    into, normal = (np.broadcast_to(v, grid.shape) for v in (at_angle(cosine), NORMAL))
    f = module("material", material.kind).evaluate(material, into, grid, normal)[:, 0]
    return float((f * equilibrium(material, grid, cosine)).sum() * share)


def equilibrium(material: Any, out: Array, cosine: float) -> Array:
    ior = getattr(material, "ior", 1.0)
    return np.where(out @ NORMAL > 0, 1.0, ior**2) / (ior**2 if cosine > 0 else 1.0)


indices = pytest.mark.parametrize("index", range(len(SCATTERING)), ids=map(repr, SCATTERING))


@indices
def test_eval_and_pdf(context: Context, lanes: int, index: int) -> None:
    material, n = SCATTERING[index], 4096
    kind = module("material", material.kind)
    into, out = unit_vectors(n, 30), unit_vectors(n, 31)
    results = ["spectrum_channel(value, 0)", "density", "spectrum_channel(seen, 0)"]
    value, pdf, seen = device(context, lanes, EVAL, results, index, **{"in": into}, out=out)
    a, b = (v.astype(float) / np.linalg.norm(v.astype(float), axis=1, keepdims=True) for v in (into, out))
    normal = np.broadcast_to(NORMAL, a.shape)
    right = kind.evaluate(material, a, b, normal)[:, 0]
    steep = (np.abs(a @ NORMAL) > 0.01) & (np.abs(b @ NORMAL) > 0.01)
    assert np.allclose(value[steep], right[steep], rtol=2e-3, atol=1e-5)
    assert np.allclose(pdf[steep], kind.density(material, a, b, normal)[steep], rtol=2e-3, atol=1e-5)
    assert (right > 0).any()
    assert not seen.any()


@indices
def test_samples_follow_the_density(context: Context, lanes: int, index: int, rng: Rng) -> None:
    """Chi-square over cells of the sphere against the integrated density, and weight × density = value."""
    n, random = 1 << 16, rng(32)
    for cosine in (-0.8, 0.3):
        into = at_angle(cosine)
        got = sampled(context, lanes, index, np.broadcast_to(into, (n, 3)), random)
        out, weight, pdf, value, density = got[:3].T, got[3], got[4], got[5], got[6]
        assert np.allclose(np.linalg.norm(out, axis=1), 1, atol=1e-6)
        lit = weight > 0
        assert np.allclose(density[lit], pdf[lit], rtol=1e-3)
        assert np.allclose((weight * density)[lit], value[lit], rtol=1e-3, atol=1e-6)

        expected = probabilities(index, cosine) * n
        counts = np.bincount(cells(out[lit]), minlength=320).astype(float)
        # Cells that expect few are taken together, with the samples that were refused.
        many = expected > 50
        expected = np.append(expected[many], n - expected[many].sum())
        counts = np.append(counts[many], n - counts[many].sum())
        # The sums over the grid are good to a per cent of a cell.
        statistic = ((counts - expected) ** 2 / (expected + 1 + (0.01 * expected) ** 2)).sum()
        accept(chi2.sf(statistic, len(counts)), f"cosine {cosine}", exact=False)


@pytest.mark.parametrize("index", range(len(EVERY)), ids=map(repr, EVERY))
def test_furnace(context: Context, lanes: int, index: int, rng: Rng) -> None:
    """In light of radiance n² everywhere, as in equilibrium, no more comes back than there is: all where nothing is
    lost, and what the oracle's integral says where light is lost between facets."""
    material, n, random = EVERY[index], 1 << 14, rng(33)
    whole = {"diffuse": 0.7, "mirror": 0.9, "dielectric": 1.0, "null": 1.0, "emissive": 0.0}
    cosines, found = (-1.0, -0.7, -0.1, 0.1, 0.7, 1.0), []
    for cosine in cosines:
        got = sampled(context, lanes, index, np.broadcast_to(at_angle(cosine), (n, 3)), random)
        found.append(got[3] * equilibrium(material, got[:3].T, cosine))
    right = [whole[material.kind] if material.kind in whole else energy(index, cosine) for cosine in cosines]
    assert max(right) <= 1 + 1e-4
    accept_mean(found, right, allowed=1e-4)


@indices
def test_reciprocity(index: int) -> None:
    """f(a → b) / n_b² = f(b → a) / n_a², of the oracle, to which the device is held."""
    material = SCATTERING[index]
    kind = module("material", material.kind)
    a, b = unit_vectors(2000, 34).astype(float), unit_vectors(2000, 35).astype(float)
    a, b = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (a, b))
    normal = np.broadcast_to(NORMAL, a.shape)
    there = kind.evaluate(material, a, b, normal)[:, 0] / np.abs(b @ NORMAL)
    back = kind.evaluate(material, -b, -a, normal)[:, 0] / np.abs(a @ NORMAL)
    ior = getattr(material, "ior", 1.0)
    n_view, n_light = np.where(a @ NORMAL < 0, 1.0, ior), np.where(b @ NORMAL > 0, 1.0, ior)
    assert (there > 0).mean() > 0.01
    assert np.allclose(there / n_view**2, back / n_light**2, rtol=1e-6, atol=1e-12)


def test_smooth_boundaries_obey_fresnel_and_snell(context: Context, lanes: int) -> None:
    n = 4096
    into = unit_vectors(n, 36)
    into[:64] = (1e-4 * into[:64].astype(float) + NORMAL) / np.linalg.norm(
        1e-4 * into[:64] + NORMAL, axis=1, keepdims=True
    )
    oracle = module("material", "dielectric")
    exact = into.astype(float) / np.linalg.norm(into.astype(float), axis=1, keepdims=True)
    normal = np.broadcast_to(NORMAL, into.shape)
    along = exact @ NORMAL
    mirrored = module("material", "mirror").reflect(exact, normal)
    for index, ior in ((6, 1.5), (7, 0.6), (8, 1.0)):
        got = sampled(context, lanes, index, into, np.random.default_rng(37))
        out, weight, pdf = got[:3].T, got[3], got[4]
        eta = np.where(along < 0, ior, 1 / ior)
        share = oracle.reflectance(np.abs(along), eta)
        w = np.random.default_rng(37).random((3, n), dtype=np.float32)[2]
        reflects = w < share
        clear = np.abs(w - share) > 1e-3 * (np.abs(along) < 0.05) + 1e-5
        right = np.where(reflects[:, None], mirrored, oracle.refract(exact, normal, eta))
        clear &= np.abs(along) > 1e-3
        assert np.allclose(out[clear], right[clear], atol=3e-4 if ior != 1 else 1e-5)
        assert np.allclose(weight[clear], np.where(reflects, 1, 1 / eta**2)[clear], rtol=1e-5)
        assert not pdf.any()
    got = sampled(context, lanes, 5, into, np.random.default_rng(37))
    assert np.allclose(got[:3].T, mirrored, atol=1e-6)
    got = sampled(context, lanes, 9, into, np.random.default_rng(37))
    assert np.array_equal(got[:3].T, into)
    assert (got[3] == 1).all()


@pytest.mark.parametrize("index", range(len(EVERY)), ids=map(repr, EVERY))
def test_no_light_leaks_where_normals_disagree(context: Context, lanes: int, index: int) -> None:
    """What comes back from a surface stays on its geometric side, what goes through it passes that too, and finite."""
    material, n = EVERY[index], 4096
    into, tilted = unit_vectors(n, 38), NORMAL + 0.6 * unit_vectors(n, 39)
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    seen = (into * tilted).sum(1) * (into @ NORMAL) > 0
    into, tilted = into[seen], tilted[seen]
    got = sampled(context, lanes, index, into, np.random.default_rng(40), shading=tilted)
    out, weight, value = got[:3].T, got[3], got[5]
    assert np.isfinite(got).all()
    lit = weight > 0
    assert (lit.mean() > 0.5) == (material.kind != "emissive")
    through = (out @ NORMAL) * (into @ NORMAL) > 0
    if material.kind in ("diffuse", "mirror"):
        assert not (through & lit).any()
    along = (out * tilted).sum(1) * (into * tilted).sum(1) > 0
    if material.kind in ("diffuse", "rough_dielectric"):
        assert np.array_equal(through[lit], along[lit])
        assert material.kind != "diffuse" or not value[~lit].any()


def test_questions_about_materials(context: Context, lanes: int) -> None:
    n = len(EVERY)
    names = ("is_delta", "is_null")
    results = [f"to_real(material_{name}(world, word_as_integer(which)))" for name in names]
    delta, null = device(context, lanes, "", results, np.arange(n), unused=np.zeros(n, np.float32))
    kinds = [material.kind for material in EVERY]
    assert [bool(d) for d in delta] == [kind not in ("diffuse", "rough_dielectric") for kind in kinds]
    assert [bool(d) for d in null] == [kind == "null" for kind in kinds]


def test_emission(context: Context, lanes: int) -> None:
    """On the normal's side, or on both; in the space of kernels, in colours."""
    lights: list[Any] = [EmissiveMaterial(radiance=(1.0, 2.0, 4.0)), EmissiveMaterial(radiance=3.0, two_sided=True)]
    world = built([DiskSurface(radius=1, material=one) for one in [*lights, NullMaterial()]])
    into = np.concatenate([unit_vectors(300, 41)] * 3)
    which = np.repeat(np.arange(3, dtype=np.uint32), 300)
    body = "spectrum seen = material_emission(world, word_as_integer(which), in, geometric);"
    results = [f"spectrum_channel(seen, {c})" for c in range(3)]
    normal = np.broadcast_to(NORMAL, into.shape)
    got = run(context, world, lanes, body, results, channels=3, which=which, geometric=normal, **{"in": into})
    oracle = module("material", "emissive").radiance
    right = [np.broadcast_to(oracle(light, into[:300], normal[:300]), (300, 3)) for light in lights]
    assert np.array_equal(got.T, np.concatenate([*right, np.zeros((300, 3))]))


def test_rough_boundaries_between_almost_equal_indices_are_taken_for_smooth(context: Context, lanes: int) -> None:
    world = built([DiskSurface(radius=1, material=RoughDielectricMaterial(ior=1.0, roughness=0.5))])
    into = unit_vectors(256, 42)
    inputs = dict(zip("uvw", np.random.default_rng(43).random((3, 256), dtype=np.float32), strict=True))
    inputs |= {name: np.broadcast_to(NORMAL, into.shape) for name in ("shading", "geometric")}
    got = run(context, world, lanes, SAMPLE, SAMPLED, which=np.zeros(256, np.uint32), **{"in": into}, **inputs)
    assert np.allclose(got[:3].T, into, atol=1e-6)
    assert np.allclose(got[3], 1)
