"""The inside of a closed triangle mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from woodcock.space import Array
from woodcock.surface import closed

FIELDS = {"bit": "uint"}


def record(index: int) -> dict[str, int]:
    """index: of the medium."""
    return {"bit": 1 << index}


def contains(corners: Array, points: Array) -> NDArray[np.bool_]:
    """Float64 oracle: are points (n, 3) inside the closed mesh of triangles (m, 9)?"""
    return np.array([closed.inside(corners, point) for point in points])
