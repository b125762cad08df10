"""Shapes on their way from one scene to another: as a surface, as the bounds of a medium, and what they contain."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from woodcock.formats import VolumeError
from woodcock.formats.mesh import read_mesh
from woodcock.importing.transforms import Array, axis_aligned, inverse, point

Fields = dict[str, Any]
Faces = NDArray[np.int32]


class Meshes(Protocol):
    """Who keeps the meshes that have no file yet."""

    def mesh(self, mesh: Mesh) -> str: ...


class Geometry(Protocol):
    def surface(self, meshes: Meshes, flipped: bool) -> tuple[Fields, bool]:
        """The surface without its material; and whether its normal still points to the other side than it should."""

    def bounds(self, meshes: Meshes) -> Fields | None:
        """The shape of a homogeneous medium; None where the surface encloses nothing."""

    def contains(self, points: Array) -> bool | None:
        """Whether all points (n, 3) lie inside; None where that is not known."""


def placement(matrix: Array) -> Fields:
    return {} if np.array_equal(matrix, np.eye(4)) else {"to_world": matrix.tolist()}


@dataclass(frozen=True)
class Sphere:
    center: Array
    radius: float

    def surface(self, meshes: Meshes, flipped: bool) -> tuple[Fields, bool]:
        return {"kind": "sphere", "center": self.center.tolist(), "radius": self.radius}, flipped

    def bounds(self, meshes: Meshes) -> Fields | None:
        return self.surface(meshes, False)[0]

    def contains(self, points: Array) -> bool | None:
        return bool((np.linalg.norm(points - self.center, axis=1) <= self.radius * (1 + 1e-5)).all())


@dataclass(frozen=True)
class Rectangle:
    """The square from -1 to 1 of the x–y plane, facing +z."""

    to_world: Array

    def surface(self, meshes: Meshes, flipped: bool) -> tuple[Fields, bool]:
        matrix = self.to_world @ np.diag((1.0, 1.0, -1.0, 1.0)) if flipped else self.to_world
        return {"kind": "rectangle", **placement(matrix)}, False

    def bounds(self, meshes: Meshes) -> Fields | None:
        return None

    def contains(self, points: Array) -> bool | None:
        return False


@dataclass(frozen=True)
class Disk:
    center: Array
    normal: Array
    radius: float

    def surface(self, meshes: Meshes, flipped: bool) -> tuple[Fields, bool]:
        normal = (-self.normal if flipped else self.normal) + 0.0
        return {
            "kind": "disk",
            "center": self.center.tolist(),
            "normal": normal.tolist(),
            "radius": self.radius,
        }, False

    def bounds(self, meshes: Meshes) -> Fields | None:
        return None

    def contains(self, points: Array) -> bool | None:
        return False


@dataclass(frozen=True)
class Mesh:
    """Triangles in the world: corners (n, 3), faces (m, 3) counter-clockwise seen from outside, normals of corners."""

    corners: Array
    faces: Faces
    normals: Array | None = None
    name: str = "mesh"

    def surface(self, meshes: Meshes, flipped: bool) -> tuple[Fields, bool]:
        normals = None if self.normals is None else -self.normals
        mesh = Mesh(self.corners, np.ascontiguousarray(self.faces[:, ::-1]), normals, self.name) if flipped else self
        return {"kind": "mesh", "file": meshes.mesh(mesh)}, False

    def bounds(self, meshes: Meshes) -> Fields | None:
        return {"kind": "mesh", "file": meshes.mesh(self)} if self.closed() else None

    def closed(self) -> bool:
        """Whether every edge has as many faces on one side as on the other; corners in one place are one."""
        _, same = np.unique(self.corners, axis=0, return_inverse=True)
        faces = same.reshape(-1)[self.faces]
        edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        forth, back = (np.unique(e, axis=0, return_counts=True) for e in (edges, edges[:, ::-1]))
        return np.array_equal(forth[0], back[0]) and np.array_equal(forth[1], back[1])

    def contains(self, points: Array) -> bool | None:
        """Sure only where the points lie behind the plane of every face, as in a convex mesh."""
        if not self.closed():
            return None
        a, b, c = (self.corners[self.faces[:, corner]] for corner in range(3))
        normals = np.cross(b - a, c - a)
        size = float(np.linalg.norm(np.ptp(self.corners, axis=0)))
        heights = points @ normals.T - np.sum(a * normals, axis=1)
        lengths = np.linalg.norm(normals, axis=1)
        outward = 1.0 if self.volume() > 0 else -1.0
        return True if bool((outward * heights <= 1e-5 * size * lengths).all()) else None

    def volume(self) -> float:
        a, b, c = (self.corners[self.faces[:, corner]] for corner in range(3))
        return float(np.sum(a * np.cross(b, c))) / 6


@dataclass(frozen=True)
class Cube:
    """The cube from -1 to 1, placed."""

    to_world: Array
    where: str

    def surface(self, meshes: Meshes, flipped: bool) -> tuple[Fields, bool]:
        corners = point(self.to_world, np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float))
        mesh = Mesh(corners, CUBE, None, "cube")
        if mesh.volume() < 0:  # a placement that mirrors
            mesh = Mesh(corners, np.ascontiguousarray(CUBE[:, ::-1]), None, "cube")
        return mesh.surface(meshes, flipped)

    def bounds(self, meshes: Meshes) -> Fields | None:
        if axis_aligned(self.to_world):
            low, high = point(self.to_world, np.array([[-1.0] * 3, [1.0] * 3])).tolist()
            return {"kind": "box", "min": low, "max": high}
        return {"kind": "box", "min": [-1.0] * 3, "max": [1.0] * 3, **placement(self.to_world)}

    def contains(self, points: Array) -> bool | None:
        return bool((np.abs(point(inverse(self.to_world, self.where), points)) <= 1 + 1e-5).all())


#: The cube's triangles, facing outwards; corner 4 z + 2 y + x.
CUBE: Faces = np.array(
    [
        *([0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6]),  # -z, +z
        *([0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3]),  # -y, +y
        *([0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]),  # -x, +x
    ],
    np.int32,
)


@dataclass(frozen=True)
class MeshFile:
    """A mesh in a file of its own: `file` as the new scene names it, `path` where it is."""

    file: str
    path: Path
    to_world: Array
    smooth: bool = True

    def surface(self, meshes: Meshes, flipped: bool) -> tuple[Fields, bool]:
        flat = {} if self.smooth else {"smooth": False}
        return {"kind": "mesh", "file": self.file, **flat, **placement(self.to_world)}, flipped

    def bounds(self, meshes: Meshes) -> Fields | None:
        return {"kind": "mesh", "file": self.file, **placement(self.to_world)}

    def contains(self, points: Array) -> bool | None:
        try:
            mesh = read_mesh(self.path)
        except VolumeError:
            return None
        corners = point(self.to_world, mesh.vertices)
        return Mesh(corners, mesh.faces.astype(np.int32)).contains(points)


def ply(mesh: Mesh) -> bytes:
    """The mesh as a binary PLY file."""
    columns = ["x", "y", "z"] + (["nx", "ny", "nz"] if mesh.normals is not None else [])
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(mesh.corners)}",
        *(f"property float {column}" for column in columns),
        f"element face {len(mesh.faces)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    vertices = mesh.corners if mesh.normals is None else np.hstack([mesh.corners, mesh.normals])
    faces = np.empty(len(mesh.faces), [("count", "u1"), ("corners", "<i4", (3,))])
    faces["count"], faces["corners"] = 3, mesh.faces
    return "\n".join([*header, ""]).encode() + vertices.astype("<f4").tobytes() + faces.tobytes()
