"""A pinhole camera."""

import numpy as np

from woodcock.camera.pose import Pose
from woodcock.scene import PerspectiveCamera
from woodcock.space import Array, Space

FIELDS = {"corner": "vector3", "right": "vector3", "down": "vector3", "origin": "vector3"}


def record(camera: PerspectiveCamera, aspect: float, space: Space) -> dict[str, Array]:
    """The film as a parallelogram on the plane that anchors the rays."""
    pose = Pose.of(camera, space)
    half_height = pose.anchor * np.tan(np.radians(camera.fov) / 2)
    corner, right, down = pose.film(pose.anchor, half_height, aspect)
    return {"corner": corner, "right": right, "down": down, "origin": pose.origin}


def ray(camera: PerspectiveCamera, aspect: float, u: Array, v: Array) -> tuple[Array, Array]:
    """Float64 oracle: origin (3,) and unit directions (..., 3) of film coordinates u, v from the upper left."""
    pose = Pose.of(camera, Space())
    height = 2 * np.tan(np.radians(camera.fov) / 2)
    x, y = (u - 0.5) * height * aspect, (0.5 - v) * height
    direction = pose.forward + x[..., None] * pose.right + y[..., None] * pose.up
    return pose.origin, direction / np.linalg.norm(direction, axis=-1, keepdims=True)
