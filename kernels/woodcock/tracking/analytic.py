"""Free flight in a homogeneous medium."""

import numpy as np

from woodcock.space import Array


def survival(sigma_t: float, distance: Array) -> Array:
    """Float64 oracle: probability of a flight longer than `distance`."""
    return np.asarray(np.exp(-sigma_t * distance))
