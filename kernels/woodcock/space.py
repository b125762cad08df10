"""The space in which kernels work: the scene moved to its middle and scaled by powers of two, so that float32 on the
device loses nothing to the scene's units, its place or the strength of its lights. Scaling by powers of two is exact:
the same scene in other units gives the same picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Space:
    """centre: (3,) of the scene; length_exponent, radiance_exponent: of the units in which kernels work."""

    centre: Array = field(default_factory=lambda: np.zeros(3))
    length_exponent: int = 0
    radiance_exponent: int = 0

    @classmethod
    def around(cls, corners: Array, strongest: float) -> Space:
        """The space of a scene: corners (n, 3) of its volumes, and its largest radiance or irradiance."""
        low, high = corners.min(axis=0), corners.max(axis=0)
        return cls(low / 2 + high / 2, _exponent(float((high - low).max())), _exponent(strongest))

    def point(self, p: Array) -> Array:
        return np.ldexp(p - self.centre, -self.length_exponent)

    def length(self, value: float) -> float:
        return math.ldexp(value, -self.length_exponent)

    def coefficient(self, value: float) -> float:
        """A coefficient per length."""
        return math.ldexp(value, self.length_exponent)

    def radiance(self, value: Array) -> Array:
        return np.ldexp(value, -self.radiance_exponent)

    def intensity(self, value: Array) -> Array:
        """A radiant intensity: radiance × area."""
        return np.ldexp(self.radiance(value), -2 * self.length_exponent)

    def affine(self, to_scene: Array) -> Array:
        """(4, 4) from local to scene -> (3, 4) from this space to local."""
        placed = to_scene.copy()
        placed[:3, 3] -= self.centre
        placed[:3] = np.ldexp(placed[:3], -self.length_exponent)
        return np.asarray(np.linalg.inv(placed)[:3])


def _exponent(value: float) -> int:
    return math.frexp(value)[1] if value > 0 else 0
