"""Where σ_t has colour, spectral MIS keeps every sample's weight bounded: dense media have no coloured fireflies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from woodcock.film import Film


@pytest.mark.parametrize("as_grid", [False, True])
@pytest.mark.parametrize("sigma_t", [[5, 20, 80], [40, 50, 60], [0, 1, 100]])
def test_no_sample_weighs_more_than_three(
    box: dict[str, Any], grid: Callable[..., Any], picture: Callable[..., Film], sigma_t: list[float], as_grid: bool
) -> None:
    """In the white furnace a sample is its path's weight: the best channel's over the mean of three, 3 at most."""
    box["volumes"][0] |= {"sigma_t": sigma_t, "albedo": 1}
    if as_grid:
        values = np.random.default_rng(5).random((4, 5, 6)).astype(np.float16)
        box["volumes"] = [grid(values, scale=sigma_t, albedo=1)]
    box["film"] = {"width": 64, "height": 64}
    film = picture(box, 1)
    assert film.mean.max() <= 3.0001
    assert film.mean.sum(axis=-1) == pytest.approx(3, rel=1e-4)  # what one channel has less, others have more


def test_samples_take_channels_in_turn(box: dict[str, Any], picture: Callable[..., Film]) -> None:
    """Three samples of a pixel have the three heroes: absorption shows in all channels, however opaque one is."""
    box["volumes"][0] |= {"sigma_t": [0, 1e3, 1e3], "albedo": 0}
    film = picture(box, 3)
    assert film.mean[..., 0] == pytest.approx(1, rel=1e-4)
    assert np.abs(film.mean[..., 1:]).max() < 1e-30
