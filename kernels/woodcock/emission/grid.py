"""An emission coefficient from a grid of numbers or colours: ε = scale × value."""

import numpy as np

from woodcock.scene import GridEmission
from woodcock.space import Array, Space

FIELDS = {"scale": "colour"}


def record(emission: GridEmission, step: float, space: Space) -> dict[str, Array]:
    """step: what a stored number is multiplied by to give the voxel's value."""
    scale = np.atleast_1d(np.array(emission.scale)) * step
    return {"scale": np.ldexp(space.radiance(scale), space.length_exponent)}


def epsilon(emission: GridEmission, values: Array) -> Array:
    """Float64 oracle: ε, (..., 1) or (..., 3), of a grid's interpolated values (..., 1) or (..., 3)."""
    return np.asarray(values * np.array(emission.scale))
