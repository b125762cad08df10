"""A camera with a thin lens."""

import numpy as np

from woodcock.camera.pose import Pose
from woodcock.scene import ThinLensCamera
from woodcock.space import Array, Space

LENS = True
FIELDS = {
    "corner": "vector3",
    "view": "vector3",
    "right": "vector3",
    "down": "vector3",
    "lens_right": "vector3",
    "lens_up": "vector3",
    "spread": "float",
}


def record(camera: ThinLensCamera, aspect: float, space: Space) -> dict[str, Array | float]:
    """The film as a parallelogram on the plane that anchors the rays; view: its corner seen from the lens's middle."""
    pose, radius = Pose.of(camera, space), space.length(camera.aperture_radius)
    half_height = pose.anchor * np.tan(np.radians(camera.fov) / 2)
    corner, right, down = pose.film(pose.anchor, half_height, aspect)
    return {
        "corner": corner,
        "view": pose.anchor * pose.forward - right / 2 - down / 2,
        "right": right,
        "down": down,
        "lens_right": radius * pose.right,
        "lens_up": radius * pose.up,
        "spread": 1 - pose.anchor / space.length(focus_distance(camera)),
    }


def focus_distance(camera: ThinLensCamera) -> float:
    """Of the plane in focus along the view direction, scene units; by default the target's."""
    if camera.focus_distance is not None:
        return camera.focus_distance
    return float(np.linalg.norm(np.array(camera.target) - np.array(camera.origin)))


def ray(camera: ThinLensCamera, aspect: float, u: Array, v: Array, lens_u: Array, lens_v: Array) -> tuple[Array, Array]:
    """Float64 oracle: origins (..., 3) on the lens and unit directions (..., 3) to where the plane in focus is met."""
    pose, focus = Pose.of(camera, Space()), focus_distance(camera)
    height = 2 * focus * np.tan(np.radians(camera.fov) / 2)
    x, y = (u - 0.5) * height * aspect, (0.5 - v) * height
    target = pose.origin + focus * pose.forward + x[..., None] * pose.right + y[..., None] * pose.up
    disk = camera.aperture_radius * np.sqrt(lens_u) * np.exp(2j * np.pi * lens_v)
    origin = pose.origin + disk.real[..., None] * pose.right + disk.imag[..., None] * pose.up
    direction = target - origin
    return origin, direction / np.linalg.norm(direction, axis=-1, keepdims=True)
