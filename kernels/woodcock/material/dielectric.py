"""A smooth boundary between two transparent materials: Fresnel's and Snell's laws."""

from __future__ import annotations

import numpy as np

from woodcock.scene.surface import DielectricMaterial
from woodcock.space import Array, Space

FIELDS = {"ior": "float"}
DELTA = True


def record(material: DielectricMaterial, space: Space) -> dict[str, float]:
    return {"ior": material.ior}


def reflectance(cosine: Array, eta: Array) -> Array:
    """Float64 oracle: of unpolarised light at a cosine of incidence, eta behind over before; Fresnel's sine and tangent
    forms (1823), which need the angles themselves."""
    incident = np.arccos(np.clip(cosine, 0, 1))
    sine = np.sin(incident) / eta
    refracted = np.arcsin(np.clip(sine, -1, 1))
    difference, total = incident - refracted, incident + refracted
    with np.errstate(divide="ignore", invalid="ignore"):
        slanted = (np.sin(difference) ** 2 / np.sin(total) ** 2 + np.tan(difference) ** 2 / np.tan(total) ** 2) / 2
    upright = ((eta - 1) / (eta + 1)) ** 2
    return np.where(sine >= 1, 1.0, np.where(incident < 1e-6, upright, slanted))


def refract(into: Array, normal: Array, eta: Array) -> Array:
    """Float64 oracle: directions after refraction; the tangential part is divided by eta. NaN where it is total."""
    cosine = (into * normal).sum(-1, keepdims=True)
    tangent = (into - cosine * normal) / np.asarray(eta)[..., None]
    with np.errstate(invalid="ignore"):
        return np.asarray(tangent + np.sign(cosine) * np.sqrt(1 - (tangent**2).sum(-1, keepdims=True)) * normal)
