"""A rough boundary between two transparent materials: Walter et al., "Microfacet Models for Refraction through Rough
Surfaces", EGSR 2007, with GGX; single scattering only.
"""

from __future__ import annotations

import numpy as np

from woodcock.material.dielectric import reflectance
from woodcock.scene.surface import RoughDielectricMaterial
from woodcock.space import Array, Space

FIELDS = {"ior": "float", "roughness": "float"}
DELTA = False


def record(material: RoughDielectricMaterial, space: Space) -> dict[str, float]:
    return {"ior": material.ior, "roughness": material.roughness}


def evaluate(material: RoughDielectricMaterial, into: Array, out: Array, normal: Array) -> Array:
    """Float64 oracle: f |cos| (..., 1) of directions of travel (..., 3), in the paper's own terms (its equations 20 and
    21), where light comes along `out` reversed and leaves along `into` reversed."""
    light, view = out, -into
    facing = np.sign((view * normal).sum(-1))[..., None]
    n = normal * facing
    reflects = (light * n).sum(-1) > 0
    outside = facing[..., 0] > 0
    n_view, n_light = np.where(outside, 1.0, material.ior), np.where(outside == reflects, 1.0, material.ior)
    half = n_light[..., None] * light + n_view[..., None] * view
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    half *= np.sign((half * n).sum(-1, keepdims=True))
    i_h, o_h = (light * half).sum(-1), (view * half).sum(-1)
    i_n, o_n = (light * n).sum(-1), (view * n).sum(-1)
    share = reflectance(np.abs(o_h), np.where(outside, material.ior, 1 / material.ior))
    common = distribution(material, half, n) * masking(material, light, n, half) * masking(material, view, n, half)
    reflected = share * common / (4 * np.abs(i_n * o_n))
    bend = n_light * i_h + n_view * o_h
    refracted = np.abs(i_h * o_h / (i_n * o_n)) * n_view**2 * (1 - share) * common / bend**2
    possible = (o_h > 0) & (i_h * i_n > 0)
    return np.where(possible, np.where(reflects, reflected, refracted) * np.abs(i_n), 0.0)[..., None]


def density(material: RoughDielectricMaterial, into: Array, out: Array, normal: Array) -> Array:
    """Float64 oracle: probability per solid angle of sampling `out` by visible normals: f |cos| / G1 of the light, and
    by the squared index where it refracts."""
    light, view = out, -into
    n = normal * np.sign((view * normal).sum(-1))[..., None]
    reflects = (light * n).sum(-1) > 0
    outside = (view * normal).sum(-1) > 0
    eta = np.where(reflects, 1.0, np.where(outside, material.ior, 1 / material.ior))
    masked = masking(material, light, n, n)
    return np.asarray(evaluate(material, into, out, normal)[..., 0] / masked * eta**2)


def distribution(material: RoughDielectricMaterial, half: Array, n: Array) -> Array:
    """D of the paper's equation 33."""
    cosine = (half * n).sum(-1)
    tangent2 = 1 / cosine**2 - 1
    alpha2 = material.roughness**2
    return np.where(cosine > 0, alpha2 / (np.pi * cosine**4 * (alpha2 + tangent2) ** 2), 0.0)


def masking(material: RoughDielectricMaterial, v: Array, n: Array, half: Array) -> Array:
    """G1 of the paper's equation 34."""
    cosine = (v * n).sum(-1)
    tangent2 = 1 / cosine**2 - 1
    return np.where((v * half).sum(-1) * cosine > 0, 2 / (1 + np.sqrt(1 + material.roughness**2 * tangent2)), 0.0)
