"""Majorants bound the density, whatever grids, their storage, places and cells are: properties, by Hypothesis.

On the host against the float64 oracle, and on the device against its own lookups along walks.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from tests.kernels.media_code import ask
from tests.kernels.test_majorant import sigma_t

from woodcock.device import Context, find
from woodcock.formats import Grid
from woodcock.integrator.full import media as calls
from woodcock.probe import probe
from woodcock.scene import GlobalMajorant, GridMajorant, GridVolume, Majorant
from woodcock.space import Array, Space
from woodcock.volume.compose import compose
from woodcock.volume.media import Medium, corners, read_media
from woodcock.volume.text import Composed

#: For the rounding of a bound to float32, and of a sum of products.
SLACK = 1 + 1e-6
#: Subnormals of float32, its ends, and what has no end in binary.
EXTREMES = (1e-45, 3e-39, 1.2e-38, 1e-30, 1e30, 3e38, 1 / 3, 1.0, 255.0)
#: The largest σ_t of a medium times its size. Over a scene that is 1e14 times as large, it is still a float32.
DEPTHS = (1e-20, 1e-3, 1.0, 7.0, 1e4, 1e20)

HOST = settings(deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])


@dataclass(frozen=True)
class Tracked:
    """Media, composed in the device's space as the loop composes them."""

    media: tuple[Medium, ...]
    majorant: Majorant
    space: Space = field(repr=False)
    composed: Composed = field(repr=False)

    @property
    def size(self) -> Array:
        """(3,) of the tracking space."""
        return np.asarray(self.composed.records[0].values["size"])

    @property
    def from_local(self) -> Array:
        """(4, 4) from the tracking space to the device's."""
        return np.linalg.inv(np.vstack([self.composed.records[0].values["to_local"], [0, 0, 0, 1]]))

    def to_scene(self, local: Array) -> Array:
        """Points (n, 3) of the tracking space in the scene."""
        points = local @ self.from_local[:3, :3].T + self.from_local[:3, 3]
        return np.asarray(np.ldexp(points, self.space.length_exponent) + self.space.centre)

    def to_local(self, points: Array) -> Array:
        placed = self.composed.records[0].values["to_local"]
        return np.asarray(self.space.point(points) @ placed[:, :3].T + placed[:, 3])

    @property
    def cells(self) -> Array:
        values = self.composed.records[1].values
        return np.array([values[f"cells_{axis}"] for axis in "xyz"])

    def bounds(self) -> Array:
        """[z][y][x], in the scene's units."""
        stored = self.composed.buffers["majorant_grid_bounds"].array().reshape(self.cells[::-1])
        return np.ldexp(stored.astype(float), -self.space.length_exponent)


@st.composite
def values(draw: st.DrawFn) -> NDArray[Any]:
    """[z][y][x] or [z][y][x][3]: of few values, in any order, and mostly empty or not."""
    side = st.sampled_from((1, 2, 3, 5, 8, 16))
    shape = draw(st.permutations([draw(side), draw(st.integers(1, 4)), draw(side | st.integers(1, 40))]))
    if draw(st.integers(0, 3)) == 0:
        shape = [*shape, 3]
    palette = draw(st.lists(st.sampled_from(EXTREMES) | st.floats(0, 10, width=32), min_size=1, max_size=5))
    empty = draw(st.sampled_from([0.0, 0.5, 0.97]))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    found = random.choice(np.array(palette, np.float32), shape) * (random.random(shape) >= empty)
    dtype = draw(st.sampled_from([np.float32, np.float16, np.uint8]))
    found = np.minimum(found, {np.float32: np.inf, np.float16: 65504, np.uint8: 255}[dtype]).astype(dtype)
    if not found.max() > 0:
        found.reshape(-1)[random.integers(found.size)] = 1
    return found


@st.composite
def placements(draw: st.DrawFn) -> Array:
    """(4, 4) from the unit cube: turned, sheared, stretched, of any size, and some of its sizes away."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    placed = np.eye(4)
    if draw(st.booleans()):
        stretched = np.diag(10.0 ** random.uniform(-1, 1, 3))
        turn = Rotation.random(rng=random).as_matrix()
        sheared = np.eye(3) + np.triu(random.uniform(-2, 2, (3, 3)), 1) * draw(st.booleans())
        placed[:3, :3] = turn @ sheared @ stretched
        placed[:3, 3] = random.uniform(-2, 2, 3)
    placed[:3] *= 10.0 ** draw(st.one_of(st.just(0), st.integers(-6, 6)))
    return placed


#: As many cells as there are voxels, a part of them, or so many that no faces of either meet.
RESOLUTIONS = st.sampled_from((1, 2, 4, 8, 16, 32)) | st.integers(1, 32)


@st.composite
def tracked(draw: st.DrawFn, majorant: st.SearchStrategy[Majorant]) -> Tracked:
    volumes, files = [], {}
    for index in range(draw(st.sampled_from((1, 1, 1, 2, 3, 4)))):
        grid = draw(values())
        placed = draw(placements())
        files[str(index)] = Grid(
            "density", grid, placed @ np.diag([*(1 / np.array(grid.shape[2::-1])), 1]), placed=True
        )
        unit = draw(st.sampled_from(DEPTHS)) / float(grid.max()) / float(np.linalg.norm(placed[:3, :3], 2))
        volumes.append(
            GridVolume(
                file=str(index),
                albedo=0,
                scale=(unit, unit / 1024, 0.0) if draw(st.integers(0, 3)) == 0 else unit,
                interpolation=draw(st.sampled_from(["trilinear", "nearest"])),
                storage_error=draw(st.sampled_from([0.0, 0.0, 1e-4, 0.01, 0.3])),
            )
        )
    read = read_media(volumes, lambda file, name: files[file])
    around = np.concatenate([corners(m.density, m.to_scene(m.density)) for m in read if m.density])
    space, chosen = Space.around(around, 1.0), draw(majorant)
    return Tracked(read, chosen, space, compose(read, space, chosen))


def places(scene: Tracked, random: np.random.Generator, count: int) -> Array:
    """(n, 3) of the tracking space: anywhere, at corners of its cells, and in every medium at random, at middles and at
    corners of voxels."""
    found = [random.random((count, 3)) * scene.size]
    if isinstance(scene.majorant, GridMajorant):
        found.append(random.integers(0, scene.cells + 1, (count, 3)) * (scene.size / scene.cells))
    for medium in scene.media:
        assert medium.density is not None
        size = np.array(medium.density.size)
        own = [random.random((count, 3)) * size, random.integers(0, size, (count, 3)) + 0.5]
        own.append(random.integers(0, size + 1, (count, 3)))
        to_scene = medium.to_scene(medium.density)
        found.append(scene.to_local(np.concatenate(own) @ to_scene[:3, :3].T + to_scene[:3, 3]))
    return np.clip(np.concatenate(found), 0, scene.size)


def largest(scene: Tracked, points: Array) -> Array:
    """σ_t at points of the tracking space; none of them is outside by its own rounding alone."""
    middle = scene.size / 2
    return sigma_t(scene.media, scene.to_scene(middle + (points - middle) * (1 - 1e-12)))


@HOST
@given(tracked(st.just(GlobalMajorant())), st.integers(0, 99))
def test_global_bounds_the_field(scene: Tracked, seed: int) -> None:
    free_path = np.ldexp(scene.composed.records[1].values["mean_free_path"], scene.space.length_exponent)
    with np.errstate(divide="ignore", over="ignore"):
        assert np.all(largest(scene, places(scene, np.random.default_rng(seed), 64)) * free_path <= SLACK)


@HOST
@given(tracked(st.builds(GridMajorant, resolution=RESOLUTIONS, blocks=st.booleans())), st.integers(0, 99))
def test_grid_bounds_every_cell_and_beyond_its_faces(scene: Tracked, seed: int) -> None:
    points = places(scene, np.random.default_rng(seed), 64)
    found, bounds = largest(scene, points), scene.bounds()
    # The device finds the cell of a point to a few roundings of the whole: on either side along every axis.
    for sides in itertools.product((-1, 1), repeat=3):
        moved = points + np.array(sides) * 2.0**-22 * scene.size
        x, y, z = np.clip(np.floor(moved * (scene.cells / scene.size)), 0, scene.cells - 1).astype(int).T
        assert np.all(found <= bounds[z, y, x] * SLACK)


@HOST
@given(values(), st.sampled_from([0.0, 1e-4, 0.01, 0.3]))
def test_stored_values_are_the_files(grid: NDArray[Any], allowed: float) -> None:
    """What bounds are made of is what a file holds, to the error that is allowed and float32's own."""
    volume = GridVolume(file="x", albedo=0, storage_error=allowed)
    (medium,) = read_media([volume], lambda file, name: Grid("density", grid, np.eye(4), placed=True))
    assert medium.density is not None
    stored = medium.density.decoded(0, len(grid)).astype(float)
    assert np.all(np.abs(stored - grid.astype(float)) <= (allowed + 2.0**-23) * float(grid.max()) + 1e-45)
    assert np.all(stored <= medium.bound.max() * SLACK + 1e-45)


#: What the calls into grids and majorants see of the loop's state.
PATH = "typedef struct { vector origin, direction; integer hero; } path;\n"
STEPS = 24
WALK = f"""
path here_ = {{vector_of(x, y, z), vector_of(dx, dy, dz), (integer)0}}, *ray = &here_;
vector origin = affine_point(&world->scene->tracking.to_local, ray->origin);
vector along = affine_direction(&world->scene->tracking.to_local, ray->direction);
real near = (real)0.f, far = (real)1e30f;
box_clip(world->scene->tracking.size, origin, along, &near, &far);
majorant_walk walk = {{0}};
mask active = test(near < far);
majorant_start(world, origin, along, near, far, &walk, active);
rng_address at = {{a, (word)0u, (word)0u, 7u}};
real worst = (real)0.f;
integer medium;
coefficient own;
for (int i = 0; i < {STEPS} && some(active); ++i) {{
    words w = rng_next(&at, active), v = rng_next(&at, active);
    // So deep that a walk through the densest cells takes some steps, and one through all others goes on to these.
    real depth = larger(walk.bound, (real)1e-37f) * (far - near) * 0.25f * unit(v.x) * unit(v.x);
    active &= ~majorant_step(world, &walk, depth, active);
    coefficient found = grids_sigma_t(world, ray, walk.t, w, (real)0.f, &medium, &own);
    real ratio = coefficient_max(found) / walk.bound;
    worst = larger(worst, pick((real)0.f, ratio, active & test(coefficient_max(found) > 0.f)));
}}
"""


def rays(scene: Tracked, random: np.random.Generator, count: int) -> dict[str, NDArray[Any]]:
    """From place to place, from inside and outside; some along an axis, or along a face of cells or voxels."""
    points = places(scene, random, count)
    start, end = points[random.integers(len(points), size=(2, count))]
    lock = random.random((count, 3)) < random.choice([0, 0.5], (count, 1))
    end = np.where(lock, start, end)
    end = np.where((end == start).all(axis=1)[:, None], start + scene.size * [0, 0, 1], end)
    turn, move = scene.from_local[:3, :3], scene.from_local[:3, 3]
    start, direction = start @ turn.T + move, (end - start) @ turn.T
    start -= direction * random.integers(0, 2, (count, 1)) * 2
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    columns = np.hstack([start, direction]).astype(np.float32).T
    return dict(zip(("x", "y", "z", "dx", "dy", "dz"), columns, strict=True)) | {"a": np.arange(count, dtype=np.uint32)}


def check_walks(context: Context, scene: Tracked, seed: int, lanes: int) -> None:
    """The device's σ_t by its own lookups never exceeds its own bound where it is asked for."""
    grey = all(medium.grey for medium in scene.media)
    bounds = "world->majorant_grid_bounds, " if scene.majorant.kind == "grid" else ""
    text = calls.grids([medium.volume for medium in scene.media], scene.majorant.kind, bounds)
    composed = scene.composed
    composed.files += ["core/box.h", f"core/coefficient_{1 if grey else 3}.h"]
    given = rays(scene, np.random.default_rng(seed), 256)
    (worst,) = ask(context, composed, ["worst"], given, lanes, body=WALK, channels=1 if grey else 3, extra=PATH + text)
    assert worst.max() <= SLACK, f"{worst.max()} times the bound, at ray {worst.argmax()}"
    assert np.isfinite(worst).all()


DEVICE = st.one_of(st.just(GlobalMajorant()), st.builds(GridMajorant, resolution=RESOLUTIONS, blocks=st.booleans()))
LANES = st.sampled_from(probe(find()).lanes)


@settings(parent=HOST, max_examples=25)
@given(tracked(DEVICE), st.integers(0, 99), LANES)
def test_walks_meet_no_density_above_their_bound(context: Context, scene: Tracked, seed: int, lanes: int) -> None:
    check_walks(context, scene, seed, lanes)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@settings(parent=HOST, max_examples=600)
@given(tracked(DEVICE), st.integers(0, 99), LANES)
def test_many_walks_meet_no_density_above_their_bound(context: Context, scene: Tracked, seed: int, lanes: int) -> None:
    check_walks(context, scene, seed, lanes)
