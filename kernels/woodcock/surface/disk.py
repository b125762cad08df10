"""A disk."""

from __future__ import annotations

import numpy as np

from woodcock.scene import DiskSurface
from woodcock.space import Array, Space

#: Numbers of one primitive: middle, unit normal, radius.
WIDTH = 7


def place(surface: DiskSurface) -> Array:
    """(1, WIDTH) in the scene."""
    n = np.array(surface.normal)
    n = n / np.abs(n).max()  # so that the norm of no direction overflows
    return np.concatenate([surface.center, n / np.linalg.norm(n), [surface.radius]])[None]


def move(numbers: Array, space: Space) -> Array:
    """Primitives (n, WIDTH) in the space of kernels."""
    moved = numbers.copy()
    moved[:, :3] = space.point(numbers[:, :3])
    moved[:, 6] = np.ldexp(numbers[:, 6], -space.length_exponent)
    return moved


def bounds(numbers: Array) -> Array:
    """(n, 2, 3): lower and upper corners of primitives."""
    middle = numbers[:, :3]
    reach = numbers[:, 6:] * np.sqrt(np.clip(1 - numbers[:, 3:6] ** 2, 0, 1))
    return np.stack([middle - reach, middle + reach], axis=1)


def area(numbers: Array) -> Array:
    return np.asarray(np.pi * numbers[:, 6] ** 2)


def intersect(numbers: Array, origin: Array, direction: Array) -> Array:
    """Float64 oracle: t > 0 (n, m) of primitives (n, WIDTH) along rays (m, 3); inf where there is none."""
    to, n = numbers[:, None, :3] - origin, numbers[:, None, 3:6]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (to * n).sum(-1) / (direction * n).sum(-1)
        away = np.linalg.norm(t[..., None] * direction - to, axis=-1)
        return np.where((t > 0) & (away <= numbers[:, None, 6]), t, np.inf)


def normal(numbers: Array, points: Array) -> Array:
    """Float64 oracle: unit normals at points (n, 3), each of one primitive."""
    return numbers[:, 3:6]
