"""Majorants bound the density: global."""

from __future__ import annotations

import numpy as np
import pytest
from tests.kernels.test_volume import GRIDS, grid_of

from woodcock.layout import module
from woodcock.scene import GridVolume
from woodcock.space import Space


@pytest.mark.parametrize("seed", range(20))
def test_global_bounds_the_trilinear_field(seed: int) -> None:
    random = np.random.default_rng(seed)
    values = (random.random(random.integers(1, 6, 3)) ** 8 * 10.0 ** random.integers(-6, 6)).astype(np.float32)
    volume, grid = GridVolume(file="x", albedo=0, scale=3), grid_of(values)
    bound = volume.scale * GRIDS.check(grid, "x")
    density = GRIDS.density(volume, grid, random.random((4096, 3)))
    assert density.max() <= bound * (1 + 1e-12)
    free_path = module("majorant", "global").record(bound, Space())["mean_free_path"]
    assert free_path == pytest.approx(1 / bound)


def test_an_empty_volume_has_a_finite_mean_free_path() -> None:
    kind = module("majorant", "global")
    longest = kind.record(0, Space(length_exponent=-60))["mean_free_path"]
    assert np.float32(longest) < np.inf
    assert kind.record(1e-300, Space())["mean_free_path"] == longest
