"""The square from -1 to 1 of the x–y plane, placed: a parallelogram."""

from __future__ import annotations

import numpy as np

from woodcock.scene import RectangleSurface
from woodcock.space import Array, Space

#: Numbers of one primitive: middle, half edges, unit normal, dual vectors of the half edges.
WIDTH = 18


def place(surface: RectangleSurface) -> Array:
    """(1, WIDTH) in the scene."""
    matrix = np.array(surface.to_world)
    right, up, out, middle = matrix[:3].T
    n = np.cross(right, up)
    n *= np.copysign(1 / np.linalg.norm(n), n @ out)
    # The rows of the inverse of (right, up, n): each is one at its edge and zero along the others.
    dual = np.linalg.inv(np.column_stack([right, up, n]))
    return np.concatenate([middle, right, up, n, dual[0], dual[1]])[None]


def move(numbers: Array, space: Space) -> Array:
    """Primitives (n, WIDTH) in the space of kernels."""
    moved = numbers.copy()
    moved[:, :3] = space.point(numbers[:, :3])
    moved[:, 3:9] = np.ldexp(numbers[:, 3:9], -space.length_exponent)
    moved[:, 12:] = np.ldexp(numbers[:, 12:], space.length_exponent)
    return moved


def bounds(numbers: Array) -> Array:
    """(n, 2, 3): lower and upper corners of primitives."""
    middle, reach = numbers[:, :3], np.abs(numbers[:, 3:6]) + np.abs(numbers[:, 6:9])
    return np.stack([middle - reach, middle + reach], axis=1)


def area(numbers: Array) -> Array:
    return np.asarray(4 * np.linalg.norm(np.cross(numbers[:, 3:6], numbers[:, 6:9]), axis=1))


def intersect(numbers: Array, origin: Array, direction: Array) -> Array:
    """Float64 oracle: t > 0 (n, m) of primitives (n, WIDTH) along rays (m, 3); inf where there is none."""
    # Solved for all at once: origin + t direction = middle + u right + v up.
    n, m = len(numbers), len(origin)
    matrix = np.empty((n, m, 3, 3))
    matrix[..., 0] = -direction
    matrix[..., 1] = numbers[:, None, 3:6]
    matrix[..., 2] = numbers[:, None, 6:9]
    singular = np.abs(np.linalg.det(matrix)) < 1e-300
    matrix[singular] = np.eye(3)
    t, u, v = np.moveaxis(np.linalg.solve(matrix, (origin - numbers[:, None, :3])[..., None])[..., 0], -1, 0)
    return np.where(~singular & (t > 0) & (np.abs(u) <= 1) & (np.abs(v) <= 1), t, np.inf)


def normal(numbers: Array, points: Array) -> Array:
    """Float64 oracle: unit normals at points (n, 3), each of one primitive."""
    return numbers[:, 9:12]
