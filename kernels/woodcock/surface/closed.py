"""Closed meshes: is one closed, and which points lie inside."""

from __future__ import annotations

import numpy as np

from woodcock.formats.mesh import MeshError
from woodcock.space import Array

#: Rays to try; each fails where it passes an edge by less than rounding, so that the second is hardly ever needed.
TRIES = 16


def check(corners: Array, file: str) -> None:
    """Raises MeshError for triangles (n, 9) with an edge that an odd number of them share.

    Corners are the same where their positions are: files repeat vertices along seams.
    """
    points = corners.reshape(-1, 3) + 0.0  # -0 is 0
    _, index = np.unique(points.view([("", np.float64)] * 3).ravel(), return_inverse=True)
    faces = index.reshape(-1, 3)
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges = edges[edges[:, 0] != edges[:, 1]]  # of triangles without area
    _, shared = np.unique(edges[:, 0] * (index.max() + 1) + edges[:, 1], return_counts=True)
    if open_edges := int((shared % 2).sum()):
        raise MeshError(
            f"{file}: has {open_edges} edges that are not shared by two faces; "
            "the shape of a medium must be a closed mesh"
        )


def inside(corners: Array, point: Array) -> bool:
    """Does a point (3,) lie inside the closed mesh of triangles (n, 9): does a ray from it cross an odd number?"""
    random = np.random.default_rng(0)
    for _ in range(TRIES):
        crossed = _crossed(corners.reshape(-1, 3, 3) - point, random.standard_normal(3))
        if crossed is not None:
            return bool(crossed % 2)
    return False  # on the surface itself


def _crossed(corners: Array, direction: Array) -> int | None:
    """How many triangles (n, 3, 3) a ray from 0 crosses; None where rounding leaves a doubt."""
    direction = direction / np.linalg.norm(direction)
    lengths = np.linalg.norm(corners, axis=2)
    # Signed volumes with each edge and the direction: all of one sign where the ray's line passes through.
    sides, doubts = np.empty((2, 3, len(corners)))
    for k in range(3):
        sides[k] = np.cross(corners[:, k], corners[:, k - 2]) @ direction
        doubts[k] = 1e-13 * lengths[:, k] * lengths[:, k - 2]
    met = (sides >= -doubts).all(axis=0) | (sides <= doubts).all(axis=0)
    doubtful = met & (np.abs(sides) <= doubts).any(axis=0)
    # The plane lies ahead where the tetrahedron's volume has the sign of the area that the line sees.
    volume = np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    doubtful |= met & (np.abs(volume) <= 1e-13 * lengths.prod(axis=1))
    if doubtful.any():
        return None
    return int((met & (volume * sides.sum(axis=0) > 0)).sum())
