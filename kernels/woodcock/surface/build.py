"""Surfaces as kernels see them: primitives under one hierarchy of boxes, and a record for each surface.

A medium whose shape is a closed mesh is bounded by a surface too: one that lets everything pass and toggles the medium.
Where the scene has a surface of the same mesh in the same place, that one toggles it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from woodcock.formats.mesh import Mesh, MeshError
from woodcock.layout import module
from woodcock.scene import MeshShape, MeshSurface, NullMaterial, Surface
from woodcock.scene.surface import Material
from woodcock.space import Array, Space
from woodcock.surface import closed, hierarchy
from woodcock.surface import mesh as triangles

#: Kinds of primitives; their numbers in the buffers are positions here.
KINDS = ("sphere", "rectangle", "disk", "mesh")

#: Triangles whose edges' cross product is shorter, in the space of kernels, are left out: float32 knows no normal of
#: theirs.
LEAST_CROSS = 1e-17


@dataclass(frozen=True)
class Body:
    """A surface in the scene: numbers (n, WIDTH) of its primitives, normals (n, 9) of a smooth mesh's corners, and the
    bits of the media that crossing it toggles."""

    kind: str
    material: Material
    numbers: Array
    normals: Array | None = None
    media: int = 0


@dataclass(frozen=True)
class Built:
    """primitives (n, 3) int32: position in KINDS, first number in that kind's buffer, body; as the leaves of `boxes`
    and `links` name them. numbers: of each kind in use. normals: as many as mesh numbers, where a mesh is smooth."""

    bodies: tuple[Body, ...]
    primitives: NDArray[np.int32]
    areas: Array
    boxes: NDArray[np.float32]
    links: NDArray[np.int32]
    numbers: dict[str, NDArray[np.float32]]
    normals: NDArray[np.float32] | None


def place(
    surfaces: Sequence[Surface], media: Sequence[tuple[int, MeshShape]], read: Callable[[str], Mesh]
) -> tuple[Body, ...]:
    """The scene's surfaces, and the boundaries of media by (index, shape); `read` gives the mesh of a file.

    Raises MeshError.
    """
    toggles: dict[tuple[str, object], int] = {}
    for index, shape in media:
        key = (shape.file, shape.to_world)
        toggles[key] = toggles.get(key, 0) | 1 << index
    bodies = []
    for surface in surfaces:
        if not isinstance(surface, MeshSurface):
            bodies.append(Body(surface.kind, surface.material, module("surface", surface.kind).place(surface)))
            continue
        mesh, matrix = read(surface.file), np.array(surface.to_world)
        smooth = surface.smooth and mesh.normals is not None
        normals = triangles.place_normals(mesh, matrix) if smooth else None
        numbers = triangles.place(mesh, matrix)
        bits = toggles.pop((surface.file, surface.to_world), 0)
        if bits:
            closed.check(mesh.vertices[mesh.faces].reshape(-1, triangles.WIDTH), surface.file)
        bodies.append(Body("mesh", surface.material, numbers, normals, bits))
    for (file, to_world), bits in toggles.items():
        mesh = read(file)
        closed.check(mesh.vertices[mesh.faces].reshape(-1, triangles.WIDTH), file)
        bodies.append(Body("mesh", NullMaterial(), triangles.place(mesh, np.array(to_world)), media=bits))
    return tuple(bodies)


def corners(bodies: Sequence[Body]) -> Array:
    """Corners (n, 3) of the bodies' bounds in the scene."""
    bounds = [module("surface", body.kind).bounds(body.numbers) for body in bodies]
    return np.concatenate([[b[:, 0].min(axis=0), b[:, 1].max(axis=0)] for b in bounds])


def media_at(bodies: Sequence[Body], point: Array) -> int:
    """Bits of the media bounded by meshes that a point (3,) of the scene lies in."""
    bits = 0
    for body in bodies:
        if body.media and closed.inside(body.numbers, point):
            bits ^= body.media
    return bits


def build(bodies: Sequence[Body], space: Space) -> Built:
    """The bodies in the space of kernels, rounded to float32 before they are bounded.

    Raises MeshError where no triangle has an area.
    """
    moved = [_moved(body, space) for body in bodies]
    primitives, bounds, areas = [], [], []
    numbers_of: dict[str, list[NDArray[np.float32]]] = {}
    normals_of: list[NDArray[np.float32]] = []
    counts = dict.fromkeys(KINDS, 0)
    for index, body in enumerate(moved):
        kind, count = module("surface", body.kind), len(body.numbers)
        first = counts[body.kind] + kind.WIDTH * np.arange(count)
        counts[body.kind] += kind.WIDTH * count
        whole = np.full(count, KINDS.index(body.kind)), first, np.full(count, index)
        primitives.append(np.stack(whole, axis=1))
        bounds.append(kind.bounds(body.numbers))
        areas.append(kind.area(body.numbers))
        numbers_of.setdefault(body.kind, []).append(body.numbers.astype(np.float32))
        if body.kind == "mesh":
            normals = np.zeros_like(body.numbers) if body.normals is None else body.normals
            normals_of.append(normals.astype(np.float32))
    if not sum(map(len, areas)):
        raise MeshError("surfaces: none has an area that float32 could tell from none")
    smooth = any(body.normals is not None for body in moved)
    tree = hierarchy.build(np.concatenate(bounds))
    return Built(
        tuple(bodies),
        np.concatenate(primitives)[tree.order].astype(np.int32),
        np.concatenate(areas)[tree.order],
        tree.boxes,
        tree.links,
        {kind: np.concatenate(numbers_of[kind]).reshape(-1) for kind in KINDS if kind in numbers_of},
        np.concatenate(normals_of).reshape(-1) if smooth else None,
    )


def _moved(body: Body, space: Space) -> Body:
    """A body in the space of kernels, its numbers rounded as kernels see them, without triangles that are none."""
    numbers = module("surface", body.kind).move(body.numbers, space).astype(np.float32).astype(np.float64)
    if body.kind != "mesh":
        return replace(body, numbers=numbers)
    solid = 2 * triangles.area(numbers) >= LEAST_CROSS
    return replace(body, numbers=numbers[solid], normals=None if body.normals is None else body.normals[solid])
