"""A sphere; its normal points outwards."""

from __future__ import annotations

import numpy as np

from woodcock.scene import SphereSurface
from woodcock.space import Array, Space

#: Numbers of one primitive: centre, radius.
WIDTH = 4


def place(surface: SphereSurface) -> Array:
    """(1, WIDTH) in the scene."""
    return np.array([[*surface.center, surface.radius]])


def move(numbers: Array, space: Space) -> Array:
    """Primitives (n, WIDTH) in the space of kernels."""
    return np.concatenate([space.point(numbers[:, :3]), np.ldexp(numbers[:, 3:], -space.length_exponent)], axis=1)


def bounds(numbers: Array) -> Array:
    """(n, 2, 3): lower and upper corners of primitives."""
    centre, radius = numbers[:, :3], numbers[:, 3:]
    return np.stack([centre - radius, centre + radius], axis=1)


def area(numbers: Array) -> Array:
    return np.asarray(4 * np.pi * numbers[:, 3] ** 2)


def intersect(numbers: Array, origin: Array, direction: Array) -> Array:
    """Float64 oracle: smallest t > 0 (n, m) of primitives (n, WIDTH) along rays (m, 3); inf where there is none."""
    f = origin - numbers[:, None, :3]
    a = (direction**2).sum(-1)
    b = (f * direction).sum(-1)
    c = (f**2).sum(-1) - numbers[:, None, 3] ** 2
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - a * c)
        near, far = (-b - root) / a, (-b + root) / a
        return np.where(near > 0, near, np.where(far > 0, far, np.inf))


def normal(numbers: Array, points: Array) -> Array:
    """Float64 oracle: unit normals at points (n, 3), each of one primitive."""
    away = points - numbers[:, :3]
    return np.asarray(away / np.linalg.norm(away, axis=-1, keepdims=True))
