"""Light from a disk of one radiance in the sky."""

from __future__ import annotations

import math

import numpy as np

from woodcock.scene import SunLight
from woodcock.space import Array, Space

FIELDS = {"towards": "vector3", "versine": "float", "density": "float", "radiance": "colour", "weight": "colour"}
ON_ESCAPE = True
SAMPLED = True
LOCAL = False


def strength(light: SunLight) -> Array:
    """The disk's radiance: ∫ L cos θ dω over the disk is the irradiance, π L sin² α."""
    return np.atleast_1d(np.array(light.irradiance)) / (math.pi * math.sin(math.radians(light.angular_radius)) ** 2)


def record(light: SunLight, space: Space) -> dict[str, Array | float]:
    """versine: 1 - cos α, without cancellation; density: of samples, per steradian; weight: radiance over density."""
    versine = 2 * math.sin(math.radians(light.angular_radius) / 2) ** 2
    density = 1 / (2 * math.pi * versine)
    brightness = space.radiance(strength(light))
    return {
        "towards": towards(light),
        "versine": versine,
        "density": density,
        "radiance": brightness,
        "weight": brightness / density,
    }


def towards(light: SunLight) -> Array:
    """Unit direction (3,) from the scene to the disk's middle."""
    direction = np.array(light.direction)
    return np.asarray(-direction / np.linalg.norm(direction))


def radiance(light: SunLight, direction: Array) -> Array:
    """Float64 oracle: radiance (..., channels) that paths of unit directions (..., 3) find on escape."""
    middle = towards(light)
    angle = np.arctan2(np.linalg.norm(np.cross(direction, middle), axis=-1), direction @ middle)
    return np.where(angle[..., None] <= math.radians(light.angular_radius), strength(light), 0.0)
