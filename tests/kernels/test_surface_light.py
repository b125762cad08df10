"""Emissive surfaces as a light, and closed meshes as media's boundaries."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.conftest import Rng
from tests.kernels.surface_code import SPACE, Array, built, run, soup
from tests.kernels.test_surface import FACES, OCTAHEDRON, matrix
from tests.statistics import accept_counts, accept_mean

from woodcock.device import Context
from woodcock.formats.mesh import Mesh, MeshError
from woodcock.scene.surface import (
    DiffuseMaterial,
    DiskSurface,
    EmissiveMaterial,
    MeshSurface,
    RectangleSurface,
    SphereSurface,
)
from woodcock.scene.volume import MeshShape
from woodcock.surface import build, closed, compose

BODY = """
light_sample s;
surface_light_sample(world, from, u, v, w, &s);
surface_hit hit = surface_intersect(world, from, s.towards, (real)1e30f, (mask)-1);
surface_point at = surface_locate(world, hit, from, s.towards);
spectrum seen = material_emission(world, at.surface, s.towards, at.geometric);
real pdf = surface_light_pdf(world, hit.primitive, from, at, s.towards);
surface_hit shadow = surface_intersect(world, from, s.towards, s.distance, (mask)-1);
"""
RESULTS = ["s.towards.x", "s.towards.y", "s.towards.z", "s.distance", "s.weight", "s.pdf", "hit.t", "pdf", "shadow.t"]
RESULTS += ["seen", "to_real(hit.primitive)"]

PLACED = matrix((0.3, 0.1, 0, 2), (0, 0.4, 0.1, -0.6), (0.1, 0, 0.3, 0))
EMITTERS: dict[str, Any] = {
    "sphere": SphereSurface(center=(2, 1, 0), radius=0.5, material=EmissiveMaterial(radiance=3.0)),
    "small sphere": SphereSurface(center=(2, 1, 0), radius=1e-4, material=EmissiveMaterial(radiance=3.0)),
    "inside": SphereSurface(radius=2, material=EmissiveMaterial(radiance=3.0, two_sided=True)),
    "disk": DiskSurface(center=(2, 0, 0), normal=(-1, 0.5, 0), radius=0.7, material=EmissiveMaterial(radiance=3.0)),
    "rectangle": RectangleSurface(to_world=PLACED, material=EmissiveMaterial(radiance=3.0, two_sided=True)),
    "mesh": MeshSurface(
        file="o", to_world=matrix((1, 0, 0, 2), (0, 1, 0, 0.5), (0, 0, 1, 0)), material=EmissiveMaterial(radiance=3.0)
    ),
}


def solid_angle(corners: Array) -> Array:
    """Of triangles (n, 3, 3) seen from 0, positive if counter-clockwise: Van Oosterom & Strackee (1983)."""
    a, b, c = corners.swapaxes(0, 1)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    below = la * lb * lc + (a * b).sum(1) * lc + (a * c).sum(1) * lb + (b * c).sum(1) * la
    return np.asarray(2 * np.arctan2((a * np.cross(b, c)).sum(1), below))


def covered(name: str) -> float:
    """The solid angle of an emitter seen from 0."""
    match name:
        case "small sphere":
            return np.pi * 1e-8 / 5
        case "inside":
            return 4 * np.pi
        case "sphere":
            return float(2 * np.pi * (1 - np.sqrt(1 - 0.25 / 5)))
        case "mesh":  # convex: every ray that meets it meets two faces
            return float(np.abs(solid_angle(OCTAHEDRON[FACES] + [2, 0.5, 0])).sum() / 2)
        case "rectangle":
            x, y, _, middle = np.array(PLACED)[:3].T
            corners = middle + np.array([-x - y, x - y, x + y, -x + y])
        case _:
            turn = np.linspace(0, 2 * np.pi, 10000, endpoint=False)[:, None]
            across = np.array([0.5, 1, 0]) / np.sqrt(1.25)
            corners = [2, 0, 0] + 0.7 * (np.cos(turn) * across + np.sin(turn) * [0, 0, 1])
    fan = np.stack([np.broadcast_to(corners[0], corners.shape), corners, np.roll(corners, -1, axis=0)], axis=1)
    return float(np.abs(solid_angle(fan).sum()))


@pytest.mark.parametrize("name", EMITTERS)
def test_emitters_are_sampled_by_their_density(context: Context, lanes: int, name: str, rng: Rng) -> None:
    """The density is the one that a ray finds; its inverse's mean is the solid angle; shadow rays end before it."""
    world, n = built([EMITTERS[name]], {"o": Mesh(OCTAHEDRON, FACES)}), 1 << 15
    uniforms = dict(zip("uvw", rng(20).random((3, n), dtype=np.float32), strict=True))
    got = run(context, world, lanes, BODY, RESULTS, **{"from": np.zeros((n, 3))}, **uniforms).astype(float)
    towards, (distance, weight, pdf, t, found, shadow, seen, _) = got[:3], got[3:]
    assert np.allclose(np.linalg.norm(towards, axis=0), 1, atol=1e-6)
    lit = weight > 0
    assert np.allclose(weight[lit] * pdf[lit], 3, rtol=1e-5)
    # All but those that the rim's rounding lets slip, or that look at another face than the one sampled.
    first = lit & (t < 1e29) & (np.abs(distance - t) < 1e-2 * t)
    assert first.sum() > 0.99 * lit.sum() or name == "mesh"
    assert (distance[first] < t[first]).all()
    assert (shadow[first] > 1e29).all()
    # Close to an edge on view the density changes by more than rounding.
    assert np.quantile(np.abs(found[first] / pdf[first] - 1), 0.99) < 1e-3
    assert np.array_equal(seen[first], np.full(first.sum(), 3.0))

    # A convex mesh's other side is hidden: what is lit and first.
    share = np.where(first, 1 / pdf, 0)
    right = covered(name)
    accept_mean(share, right, "solid angle", allowed=right * (2e-4 if name == "small sphere" else 1e-6))


def test_primitives_are_chosen_by_area_and_luminance(context: Context, lanes: int, rng: Rng) -> None:
    random = np.random.default_rng(21)
    corners = random.uniform(-1, 1, (37, 1, 3)) + random.uniform(-0.2, 0.2, (37, 3, 3))
    mesh, files = soup(corners)
    bright = EmissiveMaterial(radiance=(1.0, 2.0, 4.0))
    scene = [
        SphereSurface(
            center=(3, 0, 0), radius=0.2, material=EmissiveMaterial(radiance=(0.1, 0.0, 0.0), two_sided=True)
        ),
        mesh.model_copy(update={"material": bright}),
        DiskSurface(radius=1, material=DiffuseMaterial()),
    ]
    world, n = built(scene, files), 1 << 16
    w = rng(23).random(n, dtype=np.float32)
    results = ["to_real(gather(int, world->surface_emitters, surface_emitter(world, w)))"]
    got = run(context, world, lanes, "", results, channels=3, w=w)[0].astype(int)
    luminance = np.array([2 * 0.1 * 0.2126, 0.2126 + 2 * 0.7152 + 4 * 0.0722, 0.0])
    weight = luminance[world.primitives[:, 2]] * world.areas
    counts = np.bincount(got, minlength=len(weight))
    lit = weight > 0
    assert not counts[~lit].any()
    accept_counts(counts[lit], weight[lit])
    pdf = compose.compose(world, SPACE, 3).buffers["surface_emitter_pdf"][1]
    spheres = world.primitives[:, 0] == 0
    assert np.allclose(np.where(spheres, pdf, pdf * world.areas), weight / weight.sum(), rtol=1e-3, atol=1e-6)


def test_a_closed_mesh_bounds_a_medium() -> None:
    """Once, by a surface of its own or the scene's of the same mesh and place; the origin is inside or it is not."""
    files = {"o": Mesh(OCTAHEDRON, FACES)}
    shape, moved = MeshShape(file="o"), MeshShape(file="o", to_world=matrix((1, 0, 0, 0.5), (0, 1, 0, 0), (0, 0, 1, 0)))
    glass = MeshSurface(file="o", material=DiffuseMaterial())
    bodies = build.place([glass], [(0, shape), (2, moved), (3, shape)], files.__getitem__)
    assert [(body.material.kind, body.media) for body in bodies] == [("diffuse", 0b1001), ("null", 0b100)]
    assert [build.media_at(bodies, np.array([x, 0.0, 0.0])) for x in (-0.9, 0.2, 1.2, 1.6)] == [
        0b1001,
        0b1101,
        0b100,
        0,
    ]
    assert np.array_equal(build.corners(bodies), [[-1, -1, -1], [1, 1, 1], [-0.5, -1, -1], [1.5, 1, 1]])


def test_points_inside_a_closed_mesh() -> None:
    corners = OCTAHEDRON[FACES].reshape(-1, 9)
    points = np.random.default_rng(22).uniform(-1, 1, (300, 3))
    right = np.abs(points).sum(axis=1) < 1
    assert np.array_equal([closed.inside(corners, point) for point in points], right)
    # A hole in it is outside, whichever way its faces are turned.
    hollow = np.concatenate([corners, corners / 2])
    assert not closed.inside(hollow, np.zeros(3))
    assert closed.inside(hollow, np.array([0.0, 0.7, 0.0]))


def test_an_open_mesh_bounds_nothing() -> None:
    files = {"open.ply": Mesh(OCTAHEDRON, FACES[:-1])}
    with pytest.raises(MeshError, match=r"^open.ply: has 3 edges that are not shared by two faces; .* closed mesh$"):
        build.place([], [(0, MeshShape(file="open.ply"))], files.__getitem__)
    seams = Mesh(OCTAHEDRON[FACES].reshape(-1, 3), np.arange(24).reshape(-1, 3))
    assert build.place([], [(0, MeshShape(file="o"))], {"o": seams}.__getitem__)[0].media == 1


def test_surfaces_without_area_are_refused() -> None:
    mesh, files = soup(np.zeros((2, 3, 3)))
    with pytest.raises(MeshError, match="none has an area"):
        built([mesh], files)
