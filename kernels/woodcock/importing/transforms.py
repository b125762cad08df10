"""Affine maps as 4×4 float64 matrices for column vectors, and how other renderers' cameras look along theirs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from woodcock.importing.report import SourceError

Array = NDArray[np.float64]

#: The world's x turned round: carries a left-handed camera's picture over to a right-handed one.
MIRROR = np.diag((-1.0, 1.0, 1.0, 1.0))


def identity() -> Array:
    return np.eye(4)


def translate(x: float, y: float, z: float) -> Array:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def scale(x: float, y: float, z: float) -> Array:
    return np.diag((x, y, z, 1.0))


def rotate(axis: Array, degrees: float, where: str) -> Array:
    """By an angle about an axis through the origin, counter-clockwise seen from its tip (Rodrigues)."""
    x, y, z = unit(axis, where, "the axis of a rotation")
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    # Whole quarter turns come out exact
    sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    if degrees % 90 == 0:
        sine, cosine = round(sine), round(cosine)
    matrix = np.eye(4)
    matrix[:3, :3] += sine * cross + (1 - cosine) * cross @ cross
    return matrix


def look_at(origin: Array, target: Array, up: Array, where: str) -> Array:
    """Camera to world as Mitsuba and pbrt have it: columns up × forward, up, forward, origin."""
    forward = unit(target - origin, where, "the way from origin to target")
    side = unit(np.cross(unit(up, where, "up"), forward), where, "up, seen along the view direction,")
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = side, np.cross(forward, side), forward, origin
    return matrix


def unit(v: Array, where: str, what: str) -> Array:
    length = float(np.linalg.norm(v))
    if not 0 < length < np.inf:
        raise SourceError(f"{where}: {what} must not be zero")
    return np.asarray(v / length)


def inverse(matrix: Array, where: str) -> Array:
    """Raises SourceError for a matrix that has none."""
    check(matrix, where)
    return np.asarray(np.linalg.inv(matrix))


def check(matrix: Array, where: str) -> Array:
    """The matrix, if it is affine, finite and not singular. Raises SourceError."""
    if not (np.isfinite(matrix).all() and np.array_equal(matrix[3], (0, 0, 0, 1))):
        raise SourceError(f"{where}: a transform must be finite and affine: its last row must be 0 0 0 1")
    lengths = float(np.prod(np.linalg.norm(matrix[:3, :3], axis=1)))
    if not (0 < lengths < np.inf and abs(determinant(matrix)) > 1e-9 * lengths):
        raise SourceError(f"{where}: a transform must not be singular")
    return matrix


def determinant(matrix: Array) -> float:
    return float(np.linalg.det(matrix[:3, :3]))


def point(matrix: Array, p: Array) -> Array:
    """Points (..., 3) moved."""
    return np.asarray(p @ matrix[:3, :3].T + matrix[:3, 3])


def vector(matrix: Array, v: Array) -> Array:
    return np.asarray(v @ matrix[:3, :3].T)


def normal(matrix: Array, n: Array) -> Array:
    """Normals (..., 3) moved, of any length: they stay on their side of the surface, mirrored or not."""
    return np.asarray(n @ np.linalg.inv(matrix[:3, :3]))


def uniform_scale(matrix: Array) -> float | None:
    """The one factor by which lengths grow; None where it differs between directions."""
    gram = matrix[:3, :3].T @ matrix[:3, :3]
    factor = float(np.trace(gram)) / 3
    return float(np.sqrt(factor)) if np.allclose(gram, factor * np.eye(3), rtol=0, atol=1e-5 * factor) else None


def axis_aligned(matrix: Array) -> bool:
    """Whether axes keep their direction: a box placed by the matrix is its two corners moved."""
    linear = matrix[:3, :3]
    return bool(np.array_equal(linear, np.diag(np.diag(linear))) and (np.diag(linear) > 0).all())


@dataclass(frozen=True)
class Pose:
    """Where a camera stands: directions in the world, of unit length. `mirrored`: its picture is that of the world's
    mirror image, for a camera whose right is forward × up."""

    origin: Array
    forward: Array
    up: Array
    mirrored: bool

    @classmethod
    def of(cls, to_world: Array, forward: Array, up: Array, right: Array, where: str) -> Pose:
        """From the camera's own three directions, the one that is right in its picture included."""
        ahead, above, aside = (unit(vector(to_world, v), where, "a camera's axis") for v in (forward, up, right))
        return cls(to_world[:3, 3].copy(), ahead, above, bool(aside @ np.cross(ahead, above) < 0))

    def fields(self, world: Array) -> dict[str, list[float]]:
        """As a scene has it, in the world that `world` makes of the source's."""
        origin = point(world, self.origin)
        target = origin + vector(world, self.forward)
        return {"origin": origin.tolist(), "target": target.tolist(), "up": vector(world, self.up).tolist()}
