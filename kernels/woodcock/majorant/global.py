"""One bound on σ_t for the whole volume."""

import numpy as np

from woodcock.space import Space

FIELDS = {"mean_free_path": "float"}


def record(bound: float, space: Space) -> dict[str, float]:
    """The mean free path 1 / bound, kept finite: an empty volume has no collision at any length."""
    longest = float(np.finfo(np.float32).max) / 256
    inverse = space.coefficient(bound)
    return {"mean_free_path": min(1 / inverse, longest) if inverse > 0 else longest}
