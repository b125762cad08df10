"""Volumes: constant and grid. Storage, bricks and placement; the lookup's mean against the float64 trilinear oracle."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.kernels.device_code import KIND_NEEDS, numbers, struct

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.formats import Grid, GridInfo, VolumeError, read_grid
from woodcock.layout import Record, module
from woodcock.scene import BoxShape, ConstantVolume, GridVolume
from woodcock.space import Space

GRIDS = module("volume", "grid")
#: (depth, height, width), none a multiple of a brick.
SHAPE = (3, 6, 5)


def grid_of(values: Any) -> Grid:
    depth, height, width = values.shape
    return Grid("density", values, np.diag([1 / width, 1 / height, 1 / depth, 1]), placed=False)


@pytest.mark.parametrize(
    ("values", "storage"),
    [
        (np.arange(90, dtype=np.uint8), "uint8"),
        (np.arange(90, dtype=np.float32), "uint8"),
        (np.arange(90, dtype=np.float16) / 7, "half"),
        ((np.arange(90) / 64).astype(np.float32), "half"),
        (np.array([6e-8] + [65504] * 89, np.float16), "half"),
        ((np.arange(90) / 7).astype(np.float32), "float"),
        (np.array([1e20] * 90, np.float32), "float"),
    ],
)
def test_storage_is_the_narrowest_that_is_exact(values: Any, storage: str) -> None:
    grid = values.reshape(SHAPE)
    assert GRIDS.storage(grid) == storage
    stored = GRIDS.bricks(grid, storage).array()
    stored = stored.view(np.float16) if storage == "half" else stored
    stored = stored.astype(np.float64).reshape(1, 2, 2, 4, 4, 4)
    restored = stored.transpose(0, 3, 1, 4, 2, 5).reshape(4, 8, 8)[:3, :6, :5]
    assert np.array_equal(restored, grid.astype(np.float64))


@pytest.mark.parametrize("storage", ["uint8", "half", "float"])
def test_lookups_find_their_voxel(context: Context, lanes: int, storage: str) -> None:
    """At a voxel's centre with jitter in the middle, and beyond every face: the nearest voxel, exactly."""
    values = np.random.default_rng(6).integers(0, 256, SHAPE).astype(np.uint8)
    if storage == "half":
        values = np.where(values < 40, np.float16(6e-8) * values, np.float16(values / 3)).astype(np.float16)
    if storage == "float":
        values = (values / 3).astype(np.float32)
    volume = GridVolume(file="x", albedo=0)
    k, j, i = np.indices([n + 2 for n in SHAPE]).reshape(3, -1) - 1
    points = (np.stack([i, j, k]) + 0.5).astype(np.float32)
    largest = float(values.max())
    record = Record("volume", "grid", "kind", GRIDS.FIELDS, GRIDS.record(volume, grid_of(values), largest, Space()))
    # Jitter just below 1/2 puts the truncated position on the voxel whose centre is asked for.
    body = "words w = {(word)0u, (word)0x80000400u, (word)0x80000000u, (word)0u};"
    stored = GRIDS.bricks(values, storage)
    (got,) = evaluate(
        context,
        ["volume_grid_density(&numbers, voxels, vector_of(x, y, z), w)"],
        dict(zip("xyz", points, strict=True)),
        lanes=lanes,
        parts=[*KIND_NEEDS, struct(record), f"volume/grid_{storage}.h", "volume/grid.h", numbers(record)],
        buffers={"voxels": stored},
        body=body,
    )
    nearest = values[tuple(np.clip(axis, 0, n - 1) for axis, n in zip((k, j, i), SHAPE, strict=True))]
    assert np.allclose(got * largest, nearest.astype(float), rtol=3e-7, atol=0)


def test_oracle_is_trilinear() -> None:
    values = np.random.default_rng(8).random(SHAPE).astype(np.float32)
    volume = GridVolume(file="x", albedo=0, scale=2)
    grid = grid_of(values)
    k, j, i = np.indices(SHAPE).reshape(3, -1)
    centres = (np.stack([i, j, k], -1) + 0.5) / SHAPE[::-1]
    assert np.allclose(GRIDS.density(volume, grid, centres), 2 * values[k, j, i])
    middle = (centres[:1] + centres[-1:]) / 2
    assert values.min() < GRIDS.density(volume, grid, middle)[0] / 2 < values.max()
    assert np.array_equal(GRIDS.density(volume, grid, np.array([[-0.1, 0.5, 0.5], [0.5, 0.5, 1.1]])), [0, 0])


def test_constant_density() -> None:
    volume = ConstantVolume(shape=BoxShape(min=(0, 1, 2), max=(1, 3, 5)), sigma_t=4, albedo=0.5)
    kind = module("volume", "constant")
    assert np.array_equal(kind.density(volume, np.array([[0.5, 2, 3], [0.5, 0.5, 3]])), [4, 0])
    local = kind.record(volume, Space(np.array([0.5, 2, 3.5]), 2))["to_local"]
    assert np.allclose(local @ [-0.5 / 4, -1 / 4, -1.5 / 4, 1], 0)
    assert np.allclose(local @ [0.5 / 4, 1 / 4, 1.5 / 4, 1], 1)


@pytest.mark.parametrize(
    ("fault", "message"),
    [(np.nan, "not finite"), (np.inf, "not finite"), (-0.25, "negative densities, down to -0.25")],
)
def test_bad_densities_are_refused(tmp_path: Path, fault: float, message: str) -> None:
    values = np.ones(SHAPE, np.float32)
    values[1, 2, 3] = fault
    np.save(tmp_path / "bad.npy", values)
    with pytest.raises(VolumeError, match=rf"bad.npy: .*{message}, first at voxel \(3, 2, 1\)"):
        GRIDS.check(read_grid(tmp_path / "bad.npy"), "bad.npy")


def test_oracle_of_colours_and_of_the_nearest() -> None:
    values = np.random.default_rng(9).random((*SHAPE, 3)).astype(np.float32)
    grid = Grid("density", values, np.diag([1 / 5, 1 / 6, 1 / 3, 1]), placed=False)
    volume = GridVolume(file="x", albedo=0, scale=(1, 2, 4), interpolation="nearest")
    points = np.random.default_rng(10).random((50, 3))
    i, j, k = (points * SHAPE[::-1]).astype(int).T
    assert np.allclose(GRIDS.density(volume, grid, points), values[k, j, i] * [1, 2, 4])
    smooth = GRIDS.density(volume.model_copy(update={"interpolation": "trilinear"}), grid, points)
    for channel in range(3):
        alone = GRIDS.density(GridVolume(file="x", albedo=0), grid_of(values[..., channel]), points)
        assert np.allclose(smooth[:, channel], alone * [1, 2, 4][channel])
    tinted = GRIDS.density(GridVolume(file="x", albedo=0, scale=(1, 2, 4)), grid_of(values[..., 0]), points)
    assert np.allclose(tinted, smooth[:, :1] * [1, 2, 4])


def test_a_constant_density_may_be_turned_and_coloured() -> None:
    turned = ((0, -2, 0, 1), (2, 0, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))
    shape = BoxShape(min=(0, 0, 0), max=(1, 2, 1), to_world=turned)
    volume = ConstantVolume(shape=shape, sigma_t=(1, 2, 3), albedo=0)
    points = np.array([[-2.9, 1.9, 0.5], [0.9, 0.1, 0.5], [1.1, 0.1, 0.5], [0, 2.1, 0.5]])
    found = module("volume", "constant").density(volume, points)
    assert np.array_equal(found, [[1, 2, 3], [1, 2, 3], [0, 0, 0], [0, 0, 0]])


def test_empty_grids_are_refused() -> None:
    with pytest.raises(VolumeError, match=r"zero.vdb: grid 'density' is empty; a density needs a voxel above 0"):
        GRIDS.check(grid_of(np.zeros(SHAPE, np.float16)), "zero.vdb")


@pytest.mark.parametrize(
    ("info", "message"),
    [
        (GridInfo("d", "float", (0, 0, 0), 0), "grid 'd' is empty"),
        (
            GridInfo("d", "float", (2048, 2048, 2049), 9),
            "grid 'd' spans 2048 × 2048 × 2049 voxels; 8589934592 are the most",
        ),
    ],
)
def test_what_cannot_be_a_density_is_known_before_it_is_read(info: GridInfo, message: str) -> None:
    with pytest.raises(VolumeError, match=message.replace("(", r"\(")):
        GRIDS.check_info(info)
    GRIDS.check_info(GridInfo("d", "half", (2, 2, 2), 1))
    GRIDS.check_info(GridInfo("colours", "vec3s", (2, 2, 2), 8))
