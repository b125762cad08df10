"""Where a camera stands and how it is turned, in float64; shared by every camera kind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from woodcock.scene import OrthographicCamera, PerspectiveCamera
from woodcock.space import Array, Space


@dataclass(frozen=True)
class Pose:
    """origin: (3,) in `space`; forward, right, up: (3,) unit; depth: of the scene's middle along forward."""

    origin: Array
    forward: Array
    right: Array
    up: Array
    depth: float

    @classmethod
    def of(cls, camera: PerspectiveCamera | OrthographicCamera, space: Space) -> Pose:
        origin = space.point(np.array(camera.origin))
        forward = _unit(np.array(camera.target) - np.array(camera.origin))
        right = _unit(np.cross(forward, np.array(camera.up)))
        return cls(origin, forward, right, np.cross(right, forward), float(-origin @ forward))

    def film(self, depth: float, half_height: float, aspect: float) -> tuple[Array, Array, Array]:
        """Upper left corner, edge to the right and edge downwards of the film's image at a depth."""
        half_right, half_down = self.right * half_height * aspect, -self.up * half_height
        return self.origin + depth * self.forward - half_right - half_down, 2 * half_right, 2 * half_down


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v))
