"""Free flight by delta tracking: Woodcock et al. (1965)."""

import numpy as np

from woodcock.space import Array


def survival(optical_depth: Array) -> Array:
    """Float64 oracle: probability of a flight through so much optical depth, whatever the majorant."""
    return np.asarray(np.exp(-optical_depth))
