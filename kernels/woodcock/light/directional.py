"""Parallel light from infinitely far away."""

import numpy as np

from woodcock.scene import DirectionalLight
from woodcock.space import Array, Space

FIELDS = {"towards": "vector3", "irradiance": "colour"}
ON_ESCAPE = False
SAMPLED = True
LOCAL = False


def strength(light: DirectionalLight) -> Array:
    return np.atleast_1d(np.array(light.irradiance))


def record(light: DirectionalLight, space: Space) -> dict[str, Array]:
    return {"towards": towards(light), "irradiance": space.radiance(strength(light))}


def towards(light: DirectionalLight) -> Array:
    """Float64 oracle: unit direction (3,) from the scene to the light."""
    direction = np.array(light.direction)
    return np.asarray(-direction / np.linalg.norm(direction))
