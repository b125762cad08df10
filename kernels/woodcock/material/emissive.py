"""Shines on the normal's side, or on both, and reflects nothing."""

from __future__ import annotations

import numpy as np

from woodcock.scene.surface import EmissiveMaterial
from woodcock.space import Array, Space

FIELDS = {"radiance": "colour", "two_sided": "float"}
DELTA = True  # nothing leaves it that light could be added to

#: Of linear Rec. 709.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def strength(material: EmissiveMaterial) -> Array:
    return np.atleast_1d(np.array(material.radiance))


def record(material: EmissiveMaterial, space: Space) -> dict[str, Array | float]:
    return {"radiance": space.radiance(strength(material)), "two_sided": float(material.two_sided)}


def power(material: EmissiveMaterial) -> float:
    """Luminance, twice of what shines on both sides: what area is weighed by where lights are chosen."""
    channels = strength(material)
    luminance = float(channels @ LUMINANCE) if channels.size == 3 else float(channels[0])
    return luminance * (1 + material.two_sided)


def radiance(material: EmissiveMaterial, into: Array, normal: Array) -> Array:
    """Float64 oracle: radiance (..., channels) that rays in direction `into` (..., 3) meet."""
    shines = np.logical_or(material.two_sided, (into * normal).sum(-1) < 0)
    return np.where(shines[..., None], strength(material), 0.0)
