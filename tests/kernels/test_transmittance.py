"""The integrator `transmittance`: optical depths of cells in closed form, against oracles that share no code of it."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from scipy.stats import qmc
from tests.kernels.ray_oracles import Gridded, Homogeneous, Media, optical_depth
from tests.kernels.rays import launch, trace

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.formats import Grid
from woodcock.integrator import transmittance
from woodcock.scene import BoxShape, SceneError, SphereShape, parse

#: Sheared, mirrored, and 40 times as long in y as in z.
ANISOTROPIC = np.array([[-0.25, 0.125, 0, 1], [0, 2, 0.25, -6], [0, 0, 0.0625, 0.5], [0, 0, 0, 1]])
SHAPE = (7, 6, 5)
#: The largest error that a transmittance may have, relative to it.
LARGEST = 1e-5


def crossing(to_scene: Any, shape: tuple[int, ...], count: int = 40) -> Any:
    """Rays (n, 6) of float32 between points around a grid, between points in it, and along its planes and edges."""
    rng, size = np.random.default_rng(21), np.array(shape[::-1])
    a, b = rng.uniform(-1, 2, (count, 3)) * size, rng.uniform(0.1, 0.9, (count, 3)) * size
    a[: count // 4] = rng.uniform(0, 1, (count // 4, 3)) * size
    ends = [a, b]
    # Along x through voxels' middles, faces between them, the grid's faces, and an edge; and through corners.
    for y, z in ((0.5, 1.5), (1, 2), (0, 1.25), (0, 0), (size[1], size[2]), (0.5, 0)):
        ends[0] = np.vstack([ends[0], [-1, y, z]])
        ends[1] = np.vstack([ends[1], [1, y, z]])
    ends[0] = np.vstack([ends[0], [-1, -1, -1], size + 1, [0.5, 0.5, 0.5]])
    ends[1] = np.vstack([ends[1], [1, 1, 1], size - 1, [1.5, 2.5, 0.5]])
    origin, through = (end @ to_scene[:3, :3].T + to_scene[:3, 3] for end in ends)
    along = through - origin
    return np.hstack([origin, along / np.linalg.norm(along, axis=1, keepdims=True)]).astype(np.float32)


def check(context: Context, media: Media, rays: Any, lanes: int, *, precise: bool = True) -> None:
    """Every ray to 1e-5 if precise, and within its bound always."""
    film = trace(context, "transmittance", media, rays, lanes=lanes, precise=precise, radiance=1.0)
    right = np.stack([np.broadcast_to(np.exp(-optical_depth(media, ray)), film.channels) for ray in rays])
    off = np.abs(film.mean[0] - right)
    assert film.rejected == 0
    assert film.bound is not None
    assert np.all(film.m2 == 0)
    # The oracle is in float64, too.
    assert np.all(off <= film.bound[0] + right * (1 - np.log(right)) * 1e-13)
    if precise:
        assert np.all(off <= LARGEST * right)
        assert np.all(film.bound[0] <= LARGEST * right)


@pytest.mark.parametrize("thickest", [1e-8, 1.0, 87.0])
@pytest.mark.parametrize("nearest", [False, True])
def test_grids_are_exact_at_any_thickness(context: Context, lanes: int, thickest: float, nearest: bool) -> None:
    values = np.random.default_rng(20).random(SHAPE).astype(np.float32)
    values[2:4, 1:3, 1:4] = 0
    # Rays on a face of two voxels have the value of either where nothing is interpolated: these take one side.
    rays = crossing(ANISOTROPIC, SHAPE)[: 40 if nearest else None]
    unit = Gridded(values, ANISOTROPIC, 1.0, nearest=nearest)
    scale = thickest / max(float(optical_depth([unit], ray)[0]) for ray in rays)
    medium = Gridded(values, ANISOTROPIC, scale, nearest=nearest)
    check(context, [medium], rays, lanes)
    check(context, [medium], rays, lanes, precise=False)


def test_a_small_depth_keeps_its_digits(context: Context) -> None:
    """1 - exp(-τ) at τ about 1e-8 is right to the film's 48 bits."""
    rays = crossing(ANISOTROPIC, SHAPE)
    medium = Gridded(np.random.default_rng(20).random(SHAPE).astype(np.float32), ANISOTROPIC, 1e-8)
    film = trace(context, "transmittance", [medium], rays, lanes=4)
    absorbed = np.array([-np.expm1(-optical_depth([medium], ray)[0]) for ray in rays])
    assert np.allclose(1 - film.mean[0, :, 0], absorbed, rtol=0, atol=2**-46)


@pytest.mark.parametrize("shape", [(1, 1, 1), (1, 4, 1), (2, 1, 3)])
def test_thin_grids(context: Context, lanes: int, shape: tuple[int, ...]) -> None:
    values = np.random.default_rng(20).uniform(0.5, 1, shape).astype(np.float32)
    check(context, [Gridded(values, ANISOTROPIC, 3.0)], crossing(ANISOTROPIC, shape), lanes)


def test_optical_depth_is_exact_in_constant_media(context: Context, lanes: int) -> None:
    placed = ((1.0, 0.5, 0.0, 0.25), (0.0, 1.0, 0.0, -0.5), (0.0, 0.25, 2.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    box = BoxShape(min=(-1, 0, -1), max=(1, 2, 0.5), to_world=placed)
    ball = SphereShape(center=(0.25, 0.5, -0.125), radius=1.25)
    rays = crossing(np.diag([1.0, 1, 1, 1]), (2, 2, 2))
    for media in (
        [Homogeneous(box, 20.0)],
        [Homogeneous(ball, 30.0)],
        [Homogeneous(box, (1, 20, 3)), Homogeneous(ball, 5)],
    ):
        check(context, media, rays, lanes)
        check(context, media, rays, lanes, precise=False)


def test_overlapping_media_multiply(context: Context, lanes: int) -> None:
    media: Media = [
        Gridded(np.random.default_rng(20).random(SHAPE).astype(np.float32), ANISOTROPIC, (1.0, 2.0, 0.5)),
        Homogeneous(SphereShape(center=(0.5, -2, 0.75), radius=2.5), (0.25, 0, 1)),
        Gridded(np.random.default_rng(20).random((3, 4, 9)).astype(np.float32), np.diag([0.125, 1, 0.25, 1]), 1.5),
    ]
    check(context, media, crossing(ANISOTROPIC, SHAPE), lanes)


def test_nothing_gets_through_what_is_thick_enough(context: Context) -> None:
    rays = crossing(ANISOTROPIC, SHAPE)[-3:-1]
    media: Media = [Gridded(np.ones(SHAPE, np.float32), ANISOTROPIC, 1e30)]
    for precise in (True, False):
        film = trace(context, "transmittance", media, rays, lanes=4, precise=precise)
        assert film.rejected == 0
        assert np.all(film.mean == 0)


# Samples


def places(context: Context, numbers: Any) -> Any:
    """(n, 4)"""
    return np.stack(
        evaluate(
            context,
            [f"sequence_at_(sample, {axis}u)" for axis in range(4)],
            {"sample": np.asarray(numbers, np.uint64)},
            lanes=1,
            parts=["core/sequence.h", "#define sequence_at_(i, axis) sequence_at((uint)(i), axis)\n"],
        ),
        axis=-1,
    )


@pytest.mark.parametrize("start", [0, 4_000_000_000 // 1024 * 1024])
def test_samples_lie_evenly(context: Context, start: int) -> None:
    """Of 2^k in a row, one lies in every part of a pixel of this area, whatever its shape, and of the lens's axes.

    The mean of the first 4^k is near the middle; sample 0 lies there.
    """
    got = places(context, start + np.arange(1024))
    for k in range(11):
        for some in got.reshape(-1, 2**k, 4):
            for along in range(k + 1):
                part = np.floor(some[:, 0] * 2**along) + 2**along * np.floor(some[:, 1] * 2 ** (k - along))
                assert len(np.unique(part)) == 2**k
            assert all(len(np.unique(np.floor(some[:, axis] * 2**k))) == 2**k for axis in (2, 3))
    if start == 0:
        assert np.all(got[0] == 0.5)
        for n in (4, 16, 64, 256, 1024):
            assert np.all(np.abs(got[:n].mean(axis=0) - 0.5) < 0.25 / n)


def test_samples_are_sobols_scrambled(context: Context) -> None:
    """The first binary digit in which two samples differ is that of Sobol's points, whose others are scrambled."""
    gray = np.arange(1024) ^ np.arange(1024) >> 1
    sobol = np.empty((1024, 4), int)
    sobol[gray] = qmc.Sobol(4, scramble=False).random(1024) * 2**24
    got = (places(context, np.arange(1024)) * 2**24).astype(int)
    a, b = np.random.default_rng(22).integers(0, 1024, (2, 5000))
    assert np.array_equal(np.frexp(got[a] ^ got[b])[1], np.frexp(sobol[a] ^ sobol[b])[1])


BOX = {"kind": "constant", "shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]}, "sigma_t": 2, "albedo": 0}
GRID = {"kind": "grid", "file": "x", "albedo": 0, "scale": [9, 7, 5]}
SCENE: dict[str, Any] = {
    "camera": {"kind": "perspective", "origin": [0.5, 0.5, -1e6], "target": [0.5, 0.5, 0.5], "fov": 5e-5},
    "volumes": [BOX, GRID],
    "lights": [{"kind": "constant", "radiance": [1e-3, 2e3, 5]}],
    "film": {"width": 7, "height": 5},
}
VALUES = np.random.default_rng(20).random(SHAPE).astype(np.float32)


def read(file: str, name: str | None) -> Grid:
    depth, height, width = SHAPE
    return Grid("density", VALUES, np.diag([1 / width, 1 / height, 1 / depth, 1]), placed=False)


def test_a_scene_is_rendered_ray_by_ray(context: Context, lanes: int) -> None:
    """A camera a million sizes away costs no digits; a sample of every pixel's middle is the oracle's ray."""
    layout = transmittance.lay_out(parse(json.dumps(SCENE)), read)
    film = launch(context, layout, (5, 7), lanes=lanes, precise=True, samples=(0, 1))
    matrix = np.diag([1 / n for n in SHAPE[::-1]] + [1.0])
    media: Media = [Homogeneous(BoxShape(min=(0, 0, 0), max=(1, 1, 1)), 2.0), Gridded(VALUES, matrix, (9, 7, 5))]
    height = 2 * 1e6 * np.tan(np.radians(5e-5) / 2)
    for y, x in np.ndindex(5, 7):
        # +x is to the left of a camera that looks along +z with y up.
        tilt = np.array([-(x + 0.5 - 3.5) * height / 5, -(y + 0.5 - 2.5) * height / 5, 1e6 + 0.5])
        tilt[:2] *= (1e6 + 0.5) / 1e6
        along = tilt / np.linalg.norm(tilt)
        ray = np.concatenate([np.array([0.5, 0.5, -1e6]) + (1e6 - 1) * along / along[2], along])
        right = np.exp(-optical_depth(media, ray)) * SCENE["lights"][0]["radiance"]
        assert np.allclose(film.mean[y, x], right, rtol=1e-8, atol=0)


def test_ranges_of_samples_merge(context: Context) -> None:
    layout = transmittance.lay_out(parse(json.dumps(SCENE)), read)
    whole, first, rest = (
        launch(context, layout, (5, 7), lanes=4, precise=True, samples=samples) for samples in ((0, 9), (0, 4), (4, 9))
    )
    merged = first.merge(rest)
    assert merged.ranges == whole.ranges
    assert np.allclose(merged.mean, whole.mean, rtol=1e-13, atol=0)
    assert whole.rmse() == pytest.approx(merged.rmse(), rel=1e-6)
    assert 0 < whole.rmse() < 2**-23 * whole.mean.max()


def test_numbers_reach_the_device_unrounded(context: Context) -> None:
    layout = transmittance.lay_out(parse(json.dumps(SCENE)), read)
    numbers = layout.pack(precise=True)
    assert len(numbers) == 2 * len(layout.pack())
    assert np.float64(np.tan(np.radians(5e-5) / 2)) != np.float32(np.tan(np.radians(5e-5) / 2))
    record = layout.records[1]
    assert np.isin(record.values["corner"], numbers.view(np.float64)).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"orders": 2}, "layers and orders: the integrator transmittance has none"),
        ({"layers": ["depth"]}, "layers and orders: the integrator transmittance has none"),
        (
            {"volumes": [BOX | {"shape": {"kind": "mesh", "file": "x.ply"}}]},
            r"volumes\[0\]\.shape: the integrator transmittance knows boxes and spheres",
        ),
    ],
)
def test_what_it_does_not_know_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        transmittance.lay_out(parse(json.dumps(SCENE | change)), read)
