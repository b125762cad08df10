"""A ball."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from woodcock.scene import SphereShape
from woodcock.space import Array, Space

FIELDS = {"to_local": "affine"}


def to_scene(shape: SphereShape) -> Array:
    """(4, 4) from the ball of radius 1 at the origin to the scene."""
    matrix = np.diag([shape.radius, shape.radius, shape.radius, 1.0])
    matrix[:3, 3] = shape.center
    return matrix


def corners(shape: SphereShape) -> Array:
    """(8, 3), of the box around it, in the scene."""
    return np.asarray((2 * np.array(list(np.ndindex(2, 2, 2))) - 1) * shape.radius + np.array(shape.center))


def record(shape: SphereShape, space: Space) -> dict[str, Array]:
    return {"to_local": space.affine(to_scene(shape))}


def contains(shape: SphereShape, points: Array) -> NDArray[np.bool_]:
    """Float64 oracle: are points (..., 3) of the scene inside, or on the border?"""
    return np.asarray(np.linalg.norm(points - np.array(shape.center), axis=-1) <= shape.radius)


def interval(shape: SphereShape, origin: Array, direction: Array) -> tuple[Array, Array]:
    """Float64 oracle: where rays (n, 3) of the scene run through it, as the roots of a quadratic; NaN for a ray that
    misses. In units of the direction's length.
    """
    o = origin - np.array(shape.center)
    a, b = (direction**2).sum(-1), (o * direction).sum(-1)
    c = (o**2).sum(-1) - shape.radius**2
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b**2 - a * c)
    return (-b - root) / a, (-b + root) / a
