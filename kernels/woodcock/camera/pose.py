"""Where a camera stands and how it is turned, in float64; shared by every camera kind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from woodcock.scene import Camera, SceneError
from woodcock.space import Array, Space

#: In lengths of the scene: squares of distances are to be numbers of float32.
FARTHEST = 2.0**60


@dataclass(frozen=True)
class Pose:
    """origin: (3,) in `space`; forward, right, up: (3,) unit; depth: of the scene's middle along forward."""

    origin: Array
    forward: Array
    right: Array
    up: Array
    depth: float

    @classmethod
    def of(cls, camera: Camera, space: Space) -> Pose:
        """Raises SceneError for a camera that is too far away."""
        origin = space.point(np.array(camera.origin))
        if not np.abs(origin).max() <= FARTHEST:
            raise SceneError(
                f"camera: stands {np.abs(origin).max():.1g} times the scene's length away; {FARTHEST:.1g} is the most"
            )
        forward = _unit(np.array(camera.target) - np.array(camera.origin))
        right = _unit(np.cross(forward, np.array(camera.up)))
        return cls(origin, forward, right, np.cross(right, forward), float(-origin @ forward))

    @property
    def anchor(self) -> float:
        """Depth of the plane that anchors the rays of a camera in one point: through the scene's middle, unless the
        camera is nearer to it than half the scene's size. From there its film would be too small for float32.
        """
        return self.depth if self.depth > 0.5 else 1.0

    def film(self, depth: float, half_height: float, aspect: float) -> tuple[Array, Array, Array]:
        """Upper left corner, edge to the right and edge downwards of the film's image at a depth."""
        half_right, half_down = self.right * half_height * aspect, -self.up * half_height
        return self.origin + depth * self.forward - half_right - half_down, 2 * half_right, 2 * half_down


def _unit(v: Array) -> Array:
    v = v / np.abs(v).max()  # whose square may be none, if the numbers are large or small
    return np.asarray(v / np.linalg.norm(v))
