"""Standard errors are what they claim to be, pixel by pixel, so that agreement within them means something."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.analytic.scenes import Grid, Picture, Scene, constant, cuboid, is_clean, random_walk, white_image
from tests.conftest import z_score
from tests.statistics import accept_squares, accept_z


@pytest.mark.parametrize("medium", ["constant", "grid", "white"])
def test_errors_are_those_that_are_claimed(
    box: Scene, grid: Grid, tmp_path: Path, picture: Picture, medium: str
) -> None:
    """Deviations of 4096 pixels of a known mean, in the standard errors of each: χ² tells 10 % of the variance."""
    expected, samples = np.exp(-1.5), 2048
    match medium:
        case "constant":
            box["volumes"] = [constant(cuboid(), 1.5, 0)]
        case "grid":
            box["volumes"] = [grid(np.array([[[1]], [[5]], [[0]], [[2]]], np.uint8), scale=0.75, albedo=0)]
        case _:  # a furnace whose light is sampled
            box |= {"volumes": [constant(cuboid(), 1.5, 1)], "lights": [white_image(tmp_path)]}
            expected, samples = 1, 512
    film = picture(random_walk(box, film={"width": 64, "height": 64}), samples)
    assert is_clean(film)
    accept_z(z_score(film, expected), "of the mean")
    z = (film.mean - expected) / np.sqrt(film.variance())
    accept_squares((z**2).sum(), z.size, "of pixels")
