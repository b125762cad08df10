"""Surfaces against their float64 oracles: sphere, rectangle, disk, mesh; the hierarchy against trying all."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.kernels.surface_code import Array, built, nearest, run, soup, unit_vectors

from woodcock.device import Context
from woodcock.formats.mesh import Mesh
from woodcock.layout import module
from woodcock.scene.surface import DiskSurface, MeshSurface, RectangleSurface, SphereSurface
from woodcock.surface import hierarchy
from woodcock.surface.build import KINDS, Built

#: Hits along origin and direction, and from there along `onward`.
BODY = """
surface_hit hit = surface_intersect(world, origin, direction, limit, test(live > 0.f));
surface_point at = surface_locate(world, hit, origin, direction);
vector from = surface_leave(at, onward);
surface_hit next = surface_intersect(world, from, onward, (real)1e30f, (mask)-1);
"""
RESULTS = ["hit.t", "to_real(hit.primitive)"]
RESULTS += [f"at.{name}.{axis}" for name in ("position", "geometric", "shading") for axis in "xyz"]
RESULTS += ["at.error", "to_real(at.surface)", "from.x", "from.y", "from.z", "next.t", "to_real(next.primitive)"]

OCTAHEDRON = np.array([(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], float)
FACES = np.array([(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (1, 0, 5), (2, 1, 5), (3, 2, 5), (0, 3, 5)])


def trace(
    context: Context, world: Built, lanes: int, origin: Array, direction: Array, **more: Array
) -> dict[str, Array]:
    more = {"onward": direction, "limit": np.full(len(origin), 1e30), "live": np.ones(len(origin))} | more
    got = run(context, world, lanes, BODY, RESULTS, origin=origin, direction=direction, **more).astype(float)
    names = ("position", 2), ("geometric", 5), ("shading", 8), ("from", 13)
    vectors = {name: got[i : i + 3].T for name, i in names}
    return {"t": got[0], "primitive": got[1], "error": got[11], "surface": got[12], "next": got[16], **vectors}


def matrix(*rows: tuple[float, float, float, float]) -> Any:
    return (*rows, (0.0, 0.0, 0.0, 1.0))


def some_of_each(scale: float = 1.0, triangles: int = 300) -> Built:
    random = np.random.default_rng(5)
    middles = random.uniform(-1, 1, (triangles, 1, 3))
    corners = middles + random.uniform(-0.2, 0.2, (triangles, 3, 3))
    corners[::5, :, random.integers(3)] = middles[::5, 0, :1]  # axis-parallel
    corners[::17, 2] = corners[::17, 1]  # without area
    corners[5::17, 2] = corners[5::17].mean(axis=1)  # nearly so
    mesh, files = soup(scale * corners)
    placed = matrix((0.3, 0.1, 0, 0.2), (0, 0.4, 0.1, -0.6), (0.1, 0, 0.3, 0))
    rectangle = RectangleSurface(to_world=placed if scale == 1 else matrix(*scale * np.array(placed[:3])))
    return built(
        [
            mesh,
            SphereSurface(center=(0.2 * scale, 0.3 * scale, 0.1 * scale), radius=0.3 * scale),
            DiskSurface(center=(-0.5 * scale, 0, 0), normal=(1, 2, 3), radius=0.4 * scale),
            rectangle,
        ],
        files,
    )


def test_the_nearest_hit_is_that_of_trying_every_primitive(context: Context, lanes: int) -> None:
    """With rays from near and far, along axes, from planes of the primitives, and with a limit."""
    world, n = some_of_each(), 2048
    random = np.random.default_rng(6)
    origin = random.uniform(-1, 1, (n, 3)).astype(np.float32)
    direction = unit_vectors(n, 7)
    direction[:300] = np.repeat(np.concatenate([np.eye(3), -np.eye(3)]), 50, axis=0)
    origin[300:600] *= 100
    aimed = random.uniform(-1, 1, (300, 3)) - origin[300:600]
    direction[300:600] = aimed / np.linalg.norm(aimed, axis=1, keepdims=True)
    got = trace(context, world, lanes, origin, direction)
    right = nearest(world, origin, direction)
    hits = np.isfinite(right)
    assert 0.2 * n < hits.sum() < 0.9 * n
    assert np.array_equal(got["t"] < 1e29, hits)
    assert np.allclose(got["t"][hits], right[hits], rtol=3e-5, atol=1e-6)
    assert np.array_equal(got["primitive"] >= 0, hits)

    limit = np.where(hits, right * np.where(np.arange(n) % 2, 1.001, 0.999), 1).astype(np.float32)
    short = trace(context, world, lanes, origin, direction, limit=limit)
    assert np.array_equal(short["t"] < 1e29, hits & (np.arange(n) % 2 == 1))


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_points_lie_within_their_error_and_rays_leave_for_good(context: Context, lanes: int, scale: float) -> None:
    """Against the primitive's own float64 surface; a ray that leaves meets nothing before what the oracle meets."""
    world, n = some_of_each(scale), 4096
    origin = (scale * np.random.default_rng(8).uniform(-2, 2, (n, 3))).astype(np.float32)
    aimed = -origin + scale * 0.5 * unit_vectors(n, 9)
    direction = (aimed / np.linalg.norm(aimed, axis=1, keepdims=True)).astype(np.float32)
    onward = unit_vectors(n, 10)
    got = trace(context, world, lanes, origin, direction, onward=onward)
    hits = got["t"] < 1e29
    assert hits.sum() > n / 3

    kinds, firsts, surfaces = world.primitives[got["primitive"][hits].astype(int)].T
    assert np.array_equal(got["surface"][hits], surfaces)
    position, error, left = got["position"][hits], got["error"][hits], got["from"][hits]
    along = origin[hits].astype(float) + got["t"][hits, None] * direction[hits].astype(float)
    assert np.abs(along - position).max() < 1e-4 * scale
    side = np.sign((onward[hits] * got["geometric"][hits]).sum(-1))
    for index, kind in enumerate(KINDS):
        mine = kinds == index
        assert mine.sum() > 10
        oracle = module("surface", kind)
        numbers = world.numbers[kind].reshape(-1, oracle.WIDTH)[firsts[mine] // oracle.WIDTH].astype(float)
        normal = oracle.normal(numbers, position[mine])
        well = oracle.area(numbers) > 1e-4 * scale**2  # slivers have no normal to speak of
        assert np.allclose(got["geometric"][hits][mine][well], normal[well], atol=1e-4)
        assert np.allclose((got["shading"] - got["geometric"])[hits][mine], 0)
        if kind == "sphere":
            off = np.linalg.norm(position[mine] - numbers[:, :3], axis=1) - numbers[:, 3]
            beyond = np.linalg.norm(left[mine] - numbers[:, :3], axis=1) - numbers[:, 3]
        else:
            off = ((position[mine] - numbers[:, :3]) * normal).sum(-1)
            beyond = ((left[mine] - numbers[:, :3]) * normal).sum(-1)
        assert (np.abs(off) <= error[mine])[well].all()
        assert (beyond * side[mine] > 0)[well].all()
    right = nearest(world, left.astype(np.float32), onward[hits])
    meets = np.isfinite(right)
    agree = (got["next"][hits] < 1e29) == meets
    assert agree.mean() > 0.999  # a corner where two triangles cross may be met or not
    assert np.quantile(np.abs(got["next"][hits] - right)[agree & meets], 0.999) < 1e-4 * scale


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_no_ray_that_leaves_meets_the_same_primitive(context: Context, lanes: int, scale: float) -> None:
    """One primitive alone, far off the origin: outwards nothing, inwards a sphere's other side; also grazing."""
    n = 2048
    place = matrix((scale, 0, scale / 3, scale), (0, scale, 0, -2 * scale), (scale / 5, 0, scale, scale))
    triangle, files = soup(scale * np.array([[(1, -2, 1), (2.5, -1.7, 1.3), (0.8, -0.9, 2.5)]]))
    middle = (scale, -2 * scale, scale)
    for surface in (
        SphereSurface(center=middle, radius=scale),
        DiskSurface(center=middle, normal=(1, 1, 3), radius=scale),
        RectangleSurface(to_world=place),
        triangle,
    ):
        world = built([surface], files)
        origin = (np.array(middle) + scale * 3 * unit_vectors(n, 11)).astype(np.float32)
        aimed = np.array(middle) + scale * np.random.default_rng(12).uniform(-0.6, 0.6, (n, 3)) - origin
        direction = (aimed / np.linalg.norm(aimed, axis=1, keepdims=True)).astype(np.float32)
        first = trace(context, world, lanes, origin, direction)
        hits = first["t"] < 1e29
        assert hits.sum() > n / 10
        onward = unit_vectors(n, 13)
        across = onward - (onward * first["geometric"]).sum(-1, keepdims=True) * first["geometric"]
        grazing = across / np.linalg.norm(across, axis=1, keepdims=True) + np.float32(1e-3) * onward
        onward[::2] = (grazing / np.linalg.norm(grazing, axis=1, keepdims=True))[::2]
        got = trace(context, world, lanes, origin, direction, onward=onward)
        outwards = (onward * got["geometric"]).sum(-1)
        if surface.kind == "sphere":
            assert (got["next"][hits & (outwards > 0)] > 1e29).all()
            assert (got["next"][hits & (outwards < -1e-4)] < 2.1 * scale).all()
            inwards = hits & (outwards < -0.03)  # flatter, and where the ray starts shortens the chord
            assert np.allclose(got["next"][inwards], -2 * scale * outwards[inwards], rtol=1e-2)
        else:
            assert (got["next"][hits] > 1e29).all()


def test_closed_meshes_are_watertight(context: Context, lanes: int) -> None:
    """From inside an octahedron every ray meets it, through its edges and corners too."""
    mesh = Mesh(OCTAHEDRON, FACES)
    turned = matrix((0.36, 0.48, -0.8, 0.1), (-0.8, 0.6, 0, 0.2), (0.48, 0.64, 0.6, 0.3))
    world = built([MeshSurface(file="o", to_world=turned)], {"o": mesh})
    corners = world.numbers["mesh"].reshape(-1, 3, 3)
    weights = np.array([(1, 0, 0), (0.5, 0.5, 0), (0.3, 0.7, 0), (0.2, 0.3, 0.5)], np.float32)
    targets = np.einsum("wk,nki->nwi", weights, corners).reshape(-1, 3)
    random = np.random.default_rng(14)
    origin = (np.array([0.1, 0.2, 0.3]) + 0.3 * unit_vectors(2048, 15) * random.random((2048, 1))).astype(np.float32)
    aimed = targets[random.integers(len(targets), size=2048)] - origin
    got = trace(context, world, lanes, origin, aimed / np.linalg.norm(aimed, axis=1, keepdims=True))
    assert (got["t"] < 1.5).all()


def test_rays_cross_closed_meshes_an_even_number_of_times(context: Context, lanes: int) -> None:
    """A torus, hit by hit: in, out, in, out; what toggles a medium toggles it back."""
    around, across = 2 * np.pi * np.arange(24) / 24, 2 * np.pi * np.arange(16) / 16
    radius = 1 + 0.4 * np.cos(across)
    rings = [
        np.outer(np.cos(around), radius),
        np.outer(np.sin(around), radius),
        np.outer(np.ones(24), 0.4 * np.sin(across)),
    ]
    i, j = np.indices((24, 16)).reshape(2, -1)
    a, b, c, d = (((i + k) % 24) * 16 + (j + m) % 16 for k, m in ((0, 0), (1, 0), (1, 1), (0, 1)))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    world = built([MeshSurface(file="t")], {"t": Mesh(np.stack(rings, axis=-1).reshape(-1, 3), faces)})
    n = 4096
    origin = 3 * unit_vectors(n, 18)
    direction = np.random.default_rng(19).uniform(-1, 1, (n, 3)) - origin
    direction = (direction / np.linalg.norm(direction, axis=1, keepdims=True)).astype(np.float32)
    crossings, inside, live = np.zeros(n, int), np.zeros(n, int), np.ones(n, bool)
    while live.any():
        got = trace(context, world, lanes, origin, direction, live=live)
        assert (got["t"][~live] > 1e29).all()
        live = got["t"] < 1e29
        enters = (got["geometric"] * direction).sum(-1) < 0
        assert (enters == (inside == 0))[live].all()
        inside = np.where(live, 1 - inside, inside)
        crossings += live
        origin = np.where(live[:, None], got["from"], origin).astype(np.float32)
    assert not inside.any()
    assert set(np.unique(crossings)) == {0, 2, 4}


def test_smooth_normals(context: Context, lanes: int) -> None:
    """Of an octahedron that stands for a sphere: between the corners' normals, through a mirroring placement."""
    mirror = matrix((-2.0, 0, 0, 0), (0, 2, 0, 0), (0, 0, 1, 0))
    mesh = Mesh(OCTAHEDRON, FACES, -3 * OCTAHEDRON)  # turned inside: the face's side decides
    direction = unit_vectors(512, 16)
    origin = (-3 * direction).astype(np.float32)
    for smooth in (True, False):
        world = built([MeshSurface(file="o", to_world=mirror, smooth=smooth)], {"o": mesh})
        got = trace(context, world, lanes, origin, direction)
        assert ((got["geometric"] * direction).sum(-1) < 0).all()
        p = got["position"] / (2, 2, 1)
        right = p / np.linalg.norm(p, axis=1, keepdims=True)  # corners' normals are the axes
        right = np.where(((right * direction).sum(-1) < 0)[:, None], right, got["geometric"])
        assert np.allclose(got["shading"], right if smooth else got["geometric"], atol=1e-5)


def test_the_hierarchy_holds_every_primitive_once() -> None:
    """Boxes hold what is below them, links lead on, and equal or nested primitives are no trouble."""
    random = np.random.default_rng(17)
    middles, sizes = random.random((3000, 1, 3)), random.random((3000, 1, 3)) ** 8
    middles[:200] = middles[0]
    middles[200:300, 0, 0] = 2.0 ** -np.arange(100)
    for n in (1, 2, 5, 3000):
        bounds = np.concatenate([middles[:n] - sizes[:n], middles[:n] + sizes[:n]], axis=1)
        tree = hierarchy.build(bounds)
        assert np.array_equal(np.sort(tree.order), np.arange(n))
        seen = np.zeros(n, int)
        assert tree.links[0, 0] == len(tree.boxes)
        for index, (box, (skip, leaf)) in enumerate(zip(tree.boxes, tree.links, strict=True)):
            below = tree.links[index:skip, 1]
            below = below[below >= 0]
            members = np.concatenate([np.arange(link >> 3, (link >> 3) + (link & 7)) for link in below])
            held = bounds[tree.order[members]]
            assert (held[:, 0] >= box[:3]).all()
            assert (held[:, 1] <= box[3:]).all()
            if leaf >= 0:
                assert skip == index + 1
                seen[members] += 1
        assert (seen == 1).all()
