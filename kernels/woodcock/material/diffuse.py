"""Lambert's law, on both sides."""

from __future__ import annotations

import numpy as np

from woodcock.scene.surface import DiffuseMaterial
from woodcock.space import Array, Space

FIELDS = {"reflectance": "colour"}
DELTA = False


def record(material: DiffuseMaterial, space: Space) -> dict[str, Array]:
    return {"reflectance": np.atleast_1d(np.array(material.reflectance))}


def evaluate(material: DiffuseMaterial, into: Array, out: Array, normal: Array) -> Array:
    """Float64 oracle: f |cos| (..., channels) of directions of travel (..., 3)."""
    before, after = (into * normal).sum(-1), (out * normal).sum(-1)
    cosine = np.where(before * after < 0, np.abs(after), 0.0)
    return np.asarray(cosine[..., None] * np.atleast_1d(np.array(material.reflectance)) / np.pi)


def density(material: DiffuseMaterial, into: Array, out: Array, normal: Array) -> Array:
    """Float64 oracle: probability per solid angle of sampling `out`."""
    before, after = (into * normal).sum(-1), (out * normal).sum(-1)
    return np.where(before * after < 0, np.abs(after), 0.0) / np.pi
