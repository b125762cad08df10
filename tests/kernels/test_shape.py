"""Shapes of media: where they are and where rays run through them, against their oracles."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.kernels.device_code import KIND_NEEDS, struct

from woodcock.deterministic import lanes_of
from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.layout import WIDE, Record, module
from woodcock.scene import BoxShape, SphereShape
from woodcock.space import Space

PLACED = ((1.0, 0.5, 0.0, 0.25), (0.0, 1.0, 0.0, -0.5), (0.0, 0.25, 2.0, 0.0), (0.0, 0.0, 0.0, 1.0))
SHAPES = {
    "box": BoxShape(min=(-1, 0, -1), max=(1, 2, 0.5), to_world=PLACED),
    "sphere": SphereShape(center=(0.25, 0.5, -0.125), radius=1.25),
}
kinds = pytest.mark.parametrize("kind", SHAPES)
EXPRESSIONS = ["near", "far", "pick((real)0.f, (real)1.f, shape_{}_contains(0, o))"]


def run(context: Context, kind: str, origin: Any, along: Any, lanes: int) -> Any:
    """near, far and whether the origin is inside, for rays in local space; in the precision of the rays."""
    shape = SHAPES[kind]
    record = Record("shape", kind, "kind", module("shape", kind).FIELDS, module("shape", kind).record(shape, Space()))
    precise = origin.dtype == np.float64
    text = struct(record)
    text = text.replace("float", WIDE["float"]) if precise else text
    names = ("ox", "oy", "oz", "dx", "dy", "dz")
    return evaluate(
        context,
        [expression.format(kind) for expression in EXPRESSIONS],
        dict(zip(names, np.ascontiguousarray(np.hstack([origin, along]).T), strict=True)),
        lanes=lanes_of(lanes, precise=precise),
        parts=[*KIND_NEEDS, text, f"shape/{kind}.h"],
        body=f"""vector o = vector_of(ox, oy, oz), d = vector_of(dx, dy, dz);
            real near = (real)0.f, far = (real)1e30f;
            shape_{kind}_interval(0, o, d, &near, &far);""",
    )


@kinds
@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_intervals(context: Context, lanes: int, kind: str, precision: Any) -> None:
    """Rays from outside and inside, of the scene; the origin may be a hundred sizes away."""
    rng, oracle, shape = np.random.default_rng(30), module("shape", kind), SHAPES[kind]
    origin, target = rng.uniform(-4, 4, (200, 3)), rng.uniform(-1, 1, (200, 3))
    origin[:40] *= 25
    origin[40:80] /= 8
    along = target - origin
    local = oracle.record(shape, Space())["to_local"]
    o, d = origin @ local[:, :3].T + local[:, 3], along @ local[:, :3].T
    near, far, inside = run(context, kind, o.astype(precision), d.astype(precision), lanes)
    right_near, right_far = oracle.interval(shape, origin, along)
    right_near = np.maximum(right_near, 0)
    error = 4e-5 if precision == np.float32 else 1e-13
    met = right_far > right_near
    sure = met & (right_far - right_near > 0.01)
    assert 50 < sure.sum() < 200
    assert np.allclose(near[sure], right_near[sure], rtol=0, atol=error)
    assert np.allclose(far[sure], right_far[sure], rtol=0, atol=error)
    assert not np.any((near < far)[~met & (np.abs(np.nan_to_num(right_far - right_near, nan=1)) > 0.01)])
    assert np.array_equal(inside == 1, oracle.contains(shape, origin))


@kinds
def test_a_point_is_inside_where_its_ray_says_so(kind: str) -> None:
    """The oracles agree with each other: a point on a ray is inside between near and far."""
    rng, oracle, shape = np.random.default_rng(31), module("shape", kind), SHAPES[kind]
    origin, along = rng.uniform(-2, 2, (500, 3)), rng.uniform(-1, 1, (500, 3))
    near, far = oracle.interval(shape, origin, along)
    t = rng.uniform(-2, 2, 500)
    with np.errstate(invalid="ignore"):
        between = (near <= t) & (t <= far)
    assert 10 < between.sum() < 480
    assert np.array_equal(oracle.contains(shape, origin + t[:, None] * along), between)
    corners = oracle.corners(shape)
    inside = oracle.contains(shape, (points := rng.uniform(-3, 3, (2000, 3))))
    low, high = corners.min(axis=0), corners.max(axis=0)
    assert np.all((points[inside] >= low) & (points[inside] <= high))


def test_grazing_rays_of_a_sphere_from_afar(context: Context, lanes: int) -> None:
    """The chord at height h is 2 √(1 - h²) though the origin is 10⁴ radii away: no discriminant cancels."""
    height = np.array([0, 0.5, 0.9, 0.99, 0.999, 1.001, 2], np.float32)
    origin = np.stack([np.full(7, -1e4), height, np.zeros(7)], axis=1).astype(np.float32)
    near, far, _ = run(context, "sphere", origin, np.tile(np.float32([1, 0, 0]), (7, 1)), lanes)
    chord = 2 * np.sqrt(np.maximum(1 - height.astype(float) ** 2, 0))
    assert np.allclose((far - near)[:5], chord[:5], rtol=0, atol=2e-3)  # an ulp of 10⁴
    assert np.all(near[5:] > far[5:])


def test_rays_in_the_faces_of_a_box(context: Context, lanes: int) -> None:
    """A ray along a face or an edge is inside, one just beside it is not."""
    y = np.array([0, 1, 0, -1e-6, 1.000001], np.float32)
    origin = np.stack([np.full(5, -1), y, [0.5, 0.5, 0, 0.5, 0.5]], axis=1).astype(np.float32)
    near, far, _ = run(context, "box", origin, np.tile(np.float32([1, 0, 0]), (5, 1)), lanes)
    assert np.array_equal(near[:3], [1, 1, 1])
    assert np.array_equal(far[:3], [2, 2, 2])
    assert np.all(near[3:] > far[3:])


def test_mesh_is_where_its_bit_is_set(context: Context, lanes: int) -> None:
    inside = np.array([0, 1, 4, 5, 0xFFFFFFFF, 0xFFFFFFFB], np.uint32)
    record = Record("shape", "mesh", "kind", module("shape", "mesh").FIELDS, module("shape", "mesh").record(2))
    (far,) = evaluate(
        context,
        ["far"],
        {"inside": inside},
        lanes=lanes,
        parts=[*KIND_NEEDS, struct(record), "shape/mesh.h", "__constant struct shape_mesh numbers = {4u};\n"],
        body="real far = (real)7.f; shape_mesh_interval(&numbers, inside, &far);",
    )
    assert far.tolist() == [np.float32(-1e30)] * 2 + [7] * 3 + [np.float32(-1e30)]


def test_mesh_contains_what_a_tetrahedron_does() -> None:
    a, b, c, d = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    corners = np.array([np.concatenate(face) for face in ((a, c, b), (a, b, d), (a, d, c), (b, c, d))])
    points = np.random.default_rng(3).uniform(-0.2, 1, (200, 3))
    expected = (points > 0).all(axis=1) & (points.sum(axis=1) < 1)
    assert np.array_equal(module("shape", "mesh").contains(corners, points), expected)


def test_distance_to_the_face_ahead(context: Context, lanes: int) -> None:
    """Of a box from the origin to its size, from points inside and in its faces; also along its axes."""
    rng, size = np.random.default_rng(31), np.array([3.0, 1.0, 0.25])
    origin, along = (rng.random((400, 3)) * size).astype(np.float32), rng.normal(size=(400, 3)).astype(np.float32)
    origin[:40, 0], origin[40:80, 1], origin[80:120, 2] = 0, 1, 0.25
    along[120:160, 1:], along[160:200, ::2] = 0, 0
    (got,) = evaluate(
        context,
        ["box_exit(size, vector_of(ox, oy, oz), vector_of(dx, dy, dz))"],
        dict(
            zip(("ox", "oy", "oz", "dx", "dy", "dz"), np.ascontiguousarray(np.hstack([origin, along]).T), strict=True)
        ),
        lanes=lanes,
        parts=[*KIND_NEEDS, "core/box.h"],
        body="vector3 size = {3.f, 1.f, 0.25f};",
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        faces = np.where(along > 0, size - origin.astype(float), -origin.astype(float)) / along.astype(float)
    right = np.where(along == 0, np.inf, faces).min(axis=1)
    assert np.allclose(got, right, rtol=3e-7, atol=1e-7 * 3)
