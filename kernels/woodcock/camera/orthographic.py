"""A camera of parallel rays."""

import numpy as np

from woodcock.camera.pose import Pose
from woodcock.scene import OrthographicCamera
from woodcock.space import Array, Space

FIELDS = {"corner": "vector3", "right": "vector3", "down": "vector3", "direction": "vector3", "start": "float"}


def record(camera: OrthographicCamera, aspect: float, space: Space) -> dict[str, Array | float]:
    """The film as a rectangle on the plane through the scene's middle; the camera's plane lies at `start` from it."""
    pose = Pose.of(camera, space)
    corner, right, down = pose.film(pose.depth, space.length(camera.height) / 2, aspect)
    return {"corner": corner, "right": right, "down": down, "direction": pose.forward, "start": -pose.depth}


def ray(camera: OrthographicCamera, aspect: float, u: Array, v: Array) -> tuple[Array, Array]:
    """Float64 oracle: origins (..., 3) and the unit direction (3,) in the scene of film coordinates u, v."""
    pose = Pose.of(camera, Space())
    x, y = (u - 0.5) * camera.height * aspect, (0.5 - v) * camera.height
    return pose.origin + x[..., None] * pose.right + y[..., None] * pose.up, np.broadcast_to(
        pose.forward, (*u.shape, 3)
    )
