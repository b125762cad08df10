"""A box, axis-aligned before its placement."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from woodcock.scene import BoxShape
from woodcock.space import Array, Space

FIELDS = {"to_local": "affine"}


def to_scene(shape: BoxShape) -> Array:
    """(4, 4) from the unit cube to the scene."""
    low, high = np.array(shape.min), np.array(shape.max)
    matrix = np.diag([*(high - low), 1.0])
    matrix[:3, 3] = low
    return np.asarray(np.array(shape.to_world) @ matrix)


def corners(shape: BoxShape) -> Array:
    """(8, 3), in the scene."""
    matrix = to_scene(shape)
    return np.asarray(np.array(list(np.ndindex(2, 2, 2))) @ matrix[:3, :3].T + matrix[:3, 3])


def record(shape: BoxShape, space: Space) -> dict[str, Array]:
    return {"to_local": space.affine(to_scene(shape))}


def contains(shape: BoxShape, points: Array) -> NDArray[np.bool_]:
    """Float64 oracle: are points (..., 3) of the scene inside, or on the border?"""
    to_box = np.linalg.inv(np.array(shape.to_world))
    p = points @ to_box[:3, :3].T + to_box[:3, 3]
    return np.asarray(np.all((p >= np.array(shape.min)) & (p <= np.array(shape.max)), axis=-1))


def interval(shape: BoxShape, origin: Array, direction: Array) -> tuple[Array, Array]:
    """Float64 oracle: where rays (n, 3) of the scene run through it, by cutting them with six half-spaces; near > far
    for a ray that misses. In units of the direction's length.
    """
    matrix = np.linalg.inv(to_scene(shape))
    o, d = origin @ matrix[:3, :3].T + matrix[:3, 3], direction @ matrix[:3, :3].T
    near, far = np.full(len(o), -np.inf), np.full(len(o), np.inf)
    for axis in range(3):
        for sign, offset in ((1.0, 0.0), (-1.0, 1.0)):
            # sign · p + offset >= 0 inside.
            rise, level = sign * d[:, axis], sign * o[:, axis] + offset
            with np.errstate(divide="ignore", invalid="ignore"):
                t = -level / rise
            near = np.where(rise > 0, np.maximum(near, t), near)
            far = np.where(rise < 0, np.minimum(far, t), far)
            near = np.where((rise == 0) & (level < 0), np.inf, near)
    return near, far
