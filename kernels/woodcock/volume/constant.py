"""A homogeneous medium in a box."""

import numpy as np

from woodcock.scene import BoxShape, ConstantVolume
from woodcock.space import Array, Space

FIELDS = {"to_local": "affine", "size": "vector3", "albedo": "colour"}


def to_scene(volume: ConstantVolume) -> Array:
    """(4, 4) from the unit cube to the scene, for a medium in a box."""
    assert isinstance(volume.shape, BoxShape)
    low, high = np.array(volume.shape.min), np.array(volume.shape.max)
    matrix = np.diag([*(high - low), 1.0])
    matrix[:3, 3] = low
    return np.asarray(np.array(volume.shape.to_world) @ matrix)


def record(volume: ConstantVolume, space: Space) -> dict[str, Array]:
    return {
        "to_local": space.affine(to_scene(volume)),
        "size": np.ones(3),
        "albedo": np.atleast_1d(np.array(volume.albedo)),
    }


def density(volume: ConstantVolume, points: Array) -> Array:
    """Float64 oracle: σ_t at points (..., 3) of the scene, 0 outside; (..., 3) for a colour."""
    local = np.linalg.inv(to_scene(volume))
    p = points @ local[:3, :3].T + local[:3, 3]
    inside = np.all((p >= 0) & (p <= 1), axis=-1)
    if isinstance(volume.sigma_t, tuple):
        inside = inside[..., None]
    return np.where(inside, np.array(volume.sigma_t), 0.0)
