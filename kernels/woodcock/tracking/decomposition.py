"""Free flight by decomposition tracking: Kutz et al. (2017)."""

import numpy as np

from woodcock.space import Array


def survival(optical_depth: Array) -> Array:
    """Float64 oracle: probability of a flight through so much optical depth, whatever the control."""
    return np.asarray(np.exp(-optical_depth))
