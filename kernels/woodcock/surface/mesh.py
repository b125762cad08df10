"""Triangles of a mesh; a face's normal is that of its corners' order, counter-clockwise seen from outside."""

from __future__ import annotations

import numpy as np

from woodcock.formats.mesh import Integers, Mesh
from woodcock.space import Array, Space

#: Numbers of one primitive: three corners.
WIDTH = 9


def place(mesh: Mesh, to_world: Array) -> Array:
    """(n, WIDTH) in the scene. A mirroring placement turns the corners' order, so that the outside stays outside."""
    corners = (mesh.vertices @ to_world[:3, :3].T + to_world[:3, 3])[_order(mesh, to_world)]
    return np.asarray(corners.reshape(-1, WIDTH))


def place_normals(mesh: Mesh, to_world: Array) -> Array:
    """(n, 9) unit normals at corners in the scene; zeros where the mesh has none."""
    if mesh.normals is None:
        return np.zeros((len(mesh.faces), 9))
    # Normals go by the inverse transpose, up to its determinant's sign, which would turn them inside out.
    matrix = to_world[:3, :3] / np.abs(to_world[:3, :3]).max()
    normals = mesh.normals @ np.linalg.inv(matrix)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    return np.asarray(normals[_order(mesh, to_world)].reshape(-1, 9))


def _order(mesh: Mesh, to_world: Array) -> Integers:
    return mesh.faces[:, ::-1] if np.linalg.det(to_world[:3, :3]) < 0 else mesh.faces


def move(numbers: Array, space: Space) -> Array:
    """Primitives (n, WIDTH) in the space of kernels."""
    return space.point(numbers.reshape(-1, 3, 3)).reshape(-1, WIDTH)


def bounds(numbers: Array) -> Array:
    """(n, 2, 3): lower and upper corners of primitives."""
    corners = numbers.reshape(-1, 3, 3)
    return np.stack([corners.min(axis=1), corners.max(axis=1)], axis=1)


def area(numbers: Array) -> Array:
    return np.asarray(np.linalg.norm(_cross(numbers), axis=1) / 2)


def intersect(numbers: Array, origin: Array, direction: Array) -> Array:
    """Float64 oracle: t > 0 (n, m) of primitives (n, WIDTH) along rays (m, 3); inf where there is none.

    Möller & Trumbore, "Fast, minimum storage ray/triangle intersection", JGT 2(1), 1997.
    """
    a, b, c = (corner[:, None] for corner in np.moveaxis(numbers.reshape(-1, 3, 3), 1, 0))
    right, up, to = b - a, c - a, origin - a
    p, q = np.cross(direction, up), np.cross(to, right)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1 / (right * p).sum(-1)
        u, v, t = (to * p).sum(-1) * inverse, (direction * q).sum(-1) * inverse, (up * q).sum(-1) * inverse
        return np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0), t, np.inf)


def normal(numbers: Array, points: Array) -> Array:
    """Float64 oracle: unit normals at points (n, 3), each of one primitive."""
    n = _cross(numbers)
    return np.asarray(n / np.linalg.norm(n, axis=1, keepdims=True))


def _cross(numbers: Array) -> Array:
    a, b, c = np.moveaxis(numbers.reshape(-1, 3, 3), 1, 0)
    return np.cross(b - a, c - a)
