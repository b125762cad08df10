"""A camera that sees every direction around it."""

import numpy as np

from woodcock.camera.pose import Pose
from woodcock.scene import SphericalCamera
from woodcock.space import Array, Space

FIELDS = {"origin": "vector3", "forward": "vector3", "right": "vector3", "up": "vector3"}


def record(camera: SphericalCamera, aspect: float, space: Space) -> dict[str, Array]:
    """The film shows all directions whatever its aspect."""
    pose = Pose.of(camera, space)
    return {"origin": pose.origin, "forward": pose.forward, "right": pose.right, "up": pose.up}


def ray(camera: SphericalCamera, aspect: float, u: Array, v: Array) -> tuple[Array, Array]:
    """Float64 oracle: origin (3,) and unit directions (..., 3) of film coordinates u, v from the upper left."""
    pose = Pose.of(camera, Space())
    longitude, latitude = 2 * np.pi * (u[..., None] - 0.5), np.pi * (0.5 - v[..., None])
    level = np.cos(longitude) * pose.forward + np.sin(longitude) * pose.right
    return pose.origin, np.cos(latitude) * level + np.sin(latitude) * pose.up
