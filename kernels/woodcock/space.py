"""The space in which kernels work: the scene moved to its middle and scaled by powers of two, so that float32 on the
device loses nothing to the scene's units, its place or the strength of its lights. Scaling by powers of two is exact:
the same scene in other units gives the same picture.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from woodcock.scene import SceneError

Array = NDArray[np.float64]

#: Lengths and coefficients (times the scene's length) that the device's float32 takes with room for their squares and
#: inverses; and radiance that a picture of float32 holds, with all its digits.
LARGEST, SMALLEST, DARKEST, BRIGHTEST = 2.0**120, 2.0**-120, 2.0**-126, 2.0**127


@dataclass(frozen=True)
class Space:
    """centre: (3,) of the scene; length_exponent, radiance_exponent: of the units in which kernels work."""

    centre: Array = field(default_factory=lambda: np.zeros(3))
    length_exponent: int = 0
    radiance_exponent: int = 0

    @classmethod
    def around(cls, corners: Array, strongest: float) -> Space:
        """The space of a scene: corners (n, 3) of its volumes, and its largest radiance or irradiance.

        Raises SceneError for what float32 cannot express.
        """
        low, high = corners.min(axis=0), corners.max(axis=0)
        size = float((high / 2 - low / 2).max()) * 2
        if size != 0 and not SMALLEST <= size <= LARGEST:
            raise SceneError(f"the scene is {size:.3g} long; {SMALLEST:.1g} to {LARGEST:.1g} can be expressed")
        if strongest != 0 and not DARKEST <= strongest <= BRIGHTEST:
            raise SceneError(
                f"the scene's largest radiance, about {strongest:.3g}, is none that a picture of float32 holds "
                f"({DARKEST:.2g} to {BRIGHTEST:.2g}): use another unit"
            )
        return cls(low / 2 + high / 2, _exponent(size), _exponent(strongest))

    def point(self, p: Array) -> Array:
        return np.ldexp(p - self.centre, -self.length_exponent)

    def length(self, value: float) -> float:
        return math.ldexp(value, -self.length_exponent)

    def coefficient(self, value: float) -> float:
        """A coefficient per length. Raises SceneError for one that float32 cannot express."""
        return float(self.coefficients(np.array(value)))

    def coefficients(self, values: Array) -> Array:
        """The same of many."""
        largest = float(values.max(initial=0.0))
        if largest > math.ldexp(LARGEST, -self.length_exponent):
            size = math.ldexp(1.0, self.length_exponent)
            raise SceneError(
                f"σ_t of {largest:.3g} in a scene about {size:.1g} long: mean free paths of {1 / largest / size:.1g} "
                "of it are none that float32 can express"
            )
        return np.asarray(np.ldexp(values, self.length_exponent))

    def radiance(self, value: Array) -> Array:
        return np.ldexp(value, -self.radiance_exponent)

    def intensity(self, value: Array) -> Array:
        """A radiant intensity: radiance × area."""
        return np.ldexp(self.radiance(value), -2 * self.length_exponent)

    def affine(self, to_scene: Array) -> Array:
        """(4, 4) from local to scene -> (3, 4) from this space to local. Raises SceneError for what float32 lacks."""
        placed = to_scene.copy()
        placed[:3, 3] -= self.centre
        placed[:3] = np.ldexp(placed[:3], -self.length_exponent)
        with suppress(np.linalg.LinAlgError):
            inverse = np.asarray(np.linalg.inv(placed)[:3])
            if np.abs(inverse).max() < np.finfo(np.float32).max:
                return inverse
        raise SceneError("a shape is so thin or so far away, beside the scene's length, that float32 cannot express it")


def _exponent(value: float) -> int:
    return math.frexp(value)[1] if value > 0 else 0
