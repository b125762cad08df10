"""An environment of one radiance in every direction."""

import numpy as np

from woodcock.scene import ConstantLight
from woodcock.space import Array, Space

FIELDS = {"radiance": "colour"}
ON_ESCAPE = True
SAMPLED = False
LOCAL = False


def strength(light: ConstantLight) -> Array:
    return np.atleast_1d(np.array(light.radiance))


def record(light: ConstantLight, space: Space) -> dict[str, Array]:
    return {"radiance": space.radiance(strength(light))}


def radiance(light: ConstantLight, direction: Array) -> Array:
    """Float64 oracle: radiance (..., channels) that camera paths of directions (..., 3) find on escape."""
    return np.broadcast_to(strength(light), (*direction.shape[:-1], strength(light).size))
