"""Reflection without spreading, on both sides."""

from __future__ import annotations

import numpy as np

from woodcock.scene.surface import MirrorMaterial
from woodcock.space import Array, Space

FIELDS = {"reflectance": "colour"}
DELTA = True


def record(material: MirrorMaterial, space: Space) -> dict[str, Array]:
    return {"reflectance": np.atleast_1d(np.array(material.reflectance))}


def reflect(into: Array, normal: Array) -> Array:
    """Float64 oracle: directions after reflection, by the matrix 1 - 2 n nᵀ."""
    householder = np.eye(3) - 2 * normal[..., :, None] * normal[..., None, :]
    return np.asarray((householder @ into[..., None])[..., 0])
