"""One emission coefficient everywhere in the medium; also B(T) of a medium of one temperature."""

import numpy as np

from woodcock.space import Array, Space

FIELDS = {"epsilon": "colour"}


def record(epsilon: Array, space: Space) -> dict[str, Array]:
    """epsilon: (1,) or (3,), radiance per scene unit."""
    return {"epsilon": np.ldexp(space.radiance(epsilon), space.length_exponent)}


def epsilon(epsilon: float | tuple[float, float, float], points: Array) -> Array:
    """Float64 oracle: ε at points (..., 3), (..., 1) or (..., 3)."""
    return np.broadcast_to(np.atleast_1d(epsilon), (*points.shape[:-1], np.size(epsilon))).astype(np.float64)
