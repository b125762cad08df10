"""Majorants bound the density: global and grid. Walks through them: test_majorant_walk.py."""

from __future__ import annotations

import numpy as np
import pytest
from tests.kernels.test_volume import GRIDS, grid_of

from woodcock.formats import Grid
from woodcock.layout import module
from woodcock.scene import GridMajorant, GridVolume
from woodcock.space import Array, Space
from woodcock.volume.compose import compose
from woodcock.volume.media import Medium, read_media

MAJORANTS = module("majorant", "grid")


@pytest.mark.parametrize("seed", range(20))
def test_global_bounds_the_trilinear_field(seed: int) -> None:
    random = np.random.default_rng(seed)
    values = (random.random(random.integers(1, 6, 3)) ** 8 * 10.0 ** random.integers(-6, 6)).astype(np.float32)
    volume, grid = GridVolume(file="x", albedo=0, scale=3), grid_of(values)
    bound = 3 * GRIDS.check(grid, "x")
    density = GRIDS.density(volume, grid, random.random((4096, 3)))
    assert density.max() <= bound * (1 + 1e-12)
    free_path = module("majorant", "global").record(bound, Space())["mean_free_path"]
    assert free_path == pytest.approx(1 / bound)


def test_an_empty_volume_has_a_finite_mean_free_path() -> None:
    kind = module("majorant", "global")
    longest = kind.record(0, Space(length_exponent=-60))["mean_free_path"]
    assert np.float32(longest) < np.inf
    assert kind.record(1e-300, Space())["mean_free_path"] == longest


def random_media(random: np.random.Generator, count: int) -> tuple[Medium, ...]:
    """Grids of random sizes, sparse, some of colours, each placed at random."""
    volumes, files = [], {}
    for index in range(count):
        shape = tuple(random.integers(1, 24, 3)) + ((3,) if random.random() < 0.3 else ())
        values = (random.random(shape) ** 6 * (random.random(shape) < 0.2)).astype(np.float32)
        values[tuple(n - 1 for n in shape)] = 0.5
        placement = np.eye(4)
        placement[:3, :3] = random.normal(size=(3, 3)) + 2 * np.eye(3)
        placement[:3, 3] = random.normal(size=3)
        files[str(index)] = Grid(
            "density", values, placement @ np.diag([*(1 / np.array(shape[2::-1])), 1]), placed=True
        )
        nearest = "nearest" if random.random() < 0.3 else "trilinear"
        scale = float(10.0 ** random.integers(-3, 3))
        error = 0.01 if random.random() < 0.3 else 0.0
        volumes.append(GridVolume(file=str(index), albedo=0, scale=scale, interpolation=nearest, storage_error=error))
    return read_media(volumes, lambda file, name: files[file])


def sigma_t(media: tuple[Medium, ...], points: Array) -> Array:
    """Σ σ_t, max over channels, of what is stored."""
    total = np.zeros(len(points))
    for medium in media:
        assert medium.density is not None
        field, volume = medium.density, medium.volume
        assert isinstance(volume, GridVolume)
        stored = Grid("x", field.decoded(0, field.size[2]), field.grid.index_to_world, placed=True)
        density = GRIDS.density(volume, stored, points)
        total += density.max(axis=1) if density.ndim == 2 else density
    return total


@pytest.mark.parametrize("seed", range(24))
def test_grid_bounds_what_it_covers(seed: int) -> None:
    random = np.random.default_rng(seed)
    media = random_media(random, 1 + seed % 3)
    composed = compose(media, Space(), GridMajorant(resolution=int(random.integers(1, 20)), blocks=seed >= 12))
    tracking, majorant = (record.values for record in composed.records[:2])
    cells = np.array([majorant[f"cells_{axis}"] for axis in "xyz"])
    bounds = composed.buffers["majorant_grid_bounds"].array().reshape(cells[::-1])
    local = random.random((20000, 3)) * tracking["size"]
    to_local = np.vstack([tracking["to_local"], [0, 0, 0, 1]])
    back = np.linalg.inv(to_local)
    points = local @ back[:3, :3].T + back[:3, 3]
    # On either side of a face, for the device's rounding.
    for nudge in (-1e-7, 0, 1e-7):
        x, y, z = np.clip(np.floor(local * majorant["per_cell"] * (1 + nudge)), 0, cells - 1).astype(int).T
        assert np.all(sigma_t(media, points) <= bounds[z, y, x] * (1 + 1e-6))
    largest = sum(float(medium.bound.max()) for medium in media)
    assert bounds.max() <= largest * (1 + 2e-6)  # blocks lift bounds by that


def test_grid_is_tight() -> None:
    """A voxel bounds its own cell and those that its interpolation reaches, no others."""
    values = np.zeros((8, 8, 8), np.float32)
    values[4, 4, 4] = 2
    volume = GridVolume(file="x", albedo=0)
    for kind, expected in (("trilinear", {3, 4, 5}), ("nearest", {4})):
        media = read_media([volume.model_copy(update={"interpolation": kind})], lambda file, name: grid_of(values))
        buffers = compose(media, Space(), GridMajorant(resolution=8)).buffers
        bounds = buffers["majorant_grid_bounds"].array().reshape(8, 8, 8)
        reached = np.argwhere(bounds > 0)
        margin = 1 if kind == "nearest" else 0  # its cells' faces are the voxels', so rounding reaches the next
        assert set(reached.flatten()) == expected | {e + d for e in expected for d in (-margin, margin)}
        assert bounds[4, 4, 4] == pytest.approx(2)


def test_grid_bounds_keep_their_digits_in_extreme_units() -> None:
    values = np.full((2, 2, 2), 3e-44, np.float32)
    media = read_media([GridVolume(file="x", albedo=0, scale=1e60)], lambda file, name: grid_of(values))
    buffers = compose(media, Space(length_exponent=-50), GridMajorant(resolution=2)).buffers
    bounds = buffers["majorant_grid_bounds"].array()
    assert np.allclose(bounds, np.ldexp(1e60 * float(values[0, 0, 0]), -50), rtol=1e-6)
