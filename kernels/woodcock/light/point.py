"""Light from one point into every direction alike."""

import numpy as np

from woodcock.scene import PointLight
from woodcock.space import Array, Space

FIELDS = {"position": "vector3", "intensity": "colour"}
ON_ESCAPE = False
SAMPLED = True
LOCAL = True
#: Is there light along a part of a ray only?
SPANS = False


def strength(light: PointLight) -> Array:
    """The intensity: radiance × area, so that over the square of a length it compares with a radiance."""
    return np.atleast_1d(np.array(light.intensity))


def position(light: PointLight) -> Array:
    """(3,), scene units."""
    return np.array(light.position)


def record(light: PointLight, space: Space) -> dict[str, Array]:
    return {"position": space.point(position(light)), "intensity": space.intensity(strength(light))}


def weight(light: PointLight, points: Array) -> Array:
    """Float64 oracle: intensity over squared distance (..., channels) at points (..., 3) of the scene."""
    return np.asarray(strength(light) / np.sum((position(light) - points) ** 2, axis=-1, keepdims=True))
