"""A homogeneous medium in an axis-aligned box."""

import numpy as np

from woodcock.scene import ConstantVolume
from woodcock.space import Array, Space

FIELDS = {"to_local": "affine", "size": "vector3", "albedo": "colour"}


def to_scene(volume: ConstantVolume) -> Array:
    """(4, 4) from the unit cube to the scene."""
    low, high = np.array(volume.min), np.array(volume.max)
    matrix = np.diag([*(high - low), 1.0])
    matrix[:3, 3] = low
    return matrix


def record(volume: ConstantVolume, space: Space) -> dict[str, Array]:
    return {
        "to_local": space.affine(to_scene(volume)),
        "size": np.ones(3),
        "albedo": np.atleast_1d(np.array(volume.albedo)),
    }


def density(volume: ConstantVolume, points: Array) -> Array:
    """Float64 oracle: σ_t at points (..., 3) of the scene, 0 outside."""
    inside = np.all((points >= np.array(volume.min)) & (points <= np.array(volume.max)), axis=-1)
    return np.where(inside, volume.sigma_t, 0.0)
