"""Ranges of samples on a device, of any length, and of some pixels; contracts of a relative error by real pictures."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.stats import ttest_ind
from tests import statistics
from tests.conftest import described

from woodcock import render
from woodcock.batches import TILE, Batches, tiles
from woodcock.contract import PILOT, next_round, outcome
from woodcock.device import Device
from woodcock.drive import drive
from woodcock.film import Film
from woodcock.plan import lay_out
from woodcock.render import Renderer
from woodcock.repair import raised


@pytest.mark.parametrize("stop", [19, 20, 28])
def test_a_range_of_many_launches_is_that_range(
    box: dict[str, Any], device: Device, monkeypatch: pytest.MonkeyPatch, stop: int
) -> None:
    """Launches of 8 samples at most, the last of 1 to 8, hold what a single one does."""
    renderer = Renderer(described(box), device)
    whole = renderer.render(3, stop)
    monkeypatch.setattr(render, "LARGEST_LAUNCH", 8)
    parts = renderer.render(3, stop)
    assert parts.ranges == whole.ranges == ((3, stop),)
    assert np.array_equal(parts.count, np.full((32, 32), stop - 3))
    assert np.allclose(parts.mean, whole.mean, rtol=1e-13, atol=0)
    assert np.allclose(parts.m2, whole.m2, rtol=1e-10, atol=1e-12)


RELATIVE = {"kind": "relative_error", "relative_error": 0.02, "per": "tile"}
FEW = np.array([560, 5, 7, 3, 33, 100, 9, 200, 201, 400], np.int32)


@pytest.mark.parametrize("more", [{}, {"orders": 1}], ids=["small loop", "full loop"])
def test_a_pixel_is_the_same_in_a_list(box: dict[str, Any], device: Device, lanes: int, more: dict[str, Any]) -> None:
    """Bit by bit: whole by a program without lists, whole by one that takes them, and in a list; 0 elsewhere."""
    scene = box | more | {"film": {"width": 33, "height": 17}}
    whole = Renderer(described(scene), device, lanes=lanes)
    listed = Renderer(described(scene | {"stop": RELATIVE}), device, lanes=lanes)
    expected = whole.render(3, 20)
    chosen = np.zeros(33 * 17, bool)
    chosen[FEW] = True
    chosen = chosen.reshape(17, 33)
    for renderer, pixels, held in ((listed, None, chosen | True), (listed, FEW, chosen), (whole, FEW, chosen)):
        film = renderer.render(3, 20, pixels)
        assert film.ranges == ((3, 20),)
        assert np.array_equal(film.count, 17 * held)
        for name in ("mean", "m2"):
            assert np.array_equal(getattr(film, name), getattr(expected, name) * held[..., None])


def test_faults_are_those_of_the_pixels_in_the_list(
    box: dict[str, Any], grid: Callable[..., dict[str, Any]], device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lanes beyond the list render some of its pixels once more, and do not count."""
    monkeypatch.setattr(render, "lay_out", lambda scene, read: raised(lay_out(scene, read), 0.3))
    monkeypatch.setattr(render, "MOST_ROUNDS", 0)
    box["volumes"] = [grid(np.ones((1, 1, 1), np.float32), scale=2, albedo=0)]
    whole, listed = (Renderer(described(scene), device) for scene in (box, box | {"stop": RELATIVE}))
    assert whole.render(0, 64, FEW).faults == listed.render(0, 64, FEW).faults
    assert whole.render(0, 64, FEW).violations > 0


def test_launches_of_some_pixels_are_no_batches(box: dict[str, Any], device: Device) -> None:
    renderer = Renderer(described(box | {"stop": RELATIVE}), device)
    whole = renderer.render(0, 8).merge(renderer.render(8, 24))
    assert renderer.render(24, 30, FEW).batches == Batches()
    assert whole.merge(renderer.render(24, 30, FEW)).batches == whole.batches
    assert whole.batches.samples == 24
    assert whole.batches.mean == pytest.approx(whole.mean_luminance(), rel=1e-12)


def strip(box: dict[str, Any], seed: int = 7, **keys: Any) -> dict[str, Any]:
    """Three tiles: the sky, noise, the sky."""
    return box | {"film": {"width": 3 * TILE, "height": TILE}, "seed": seed, "stop": RELATIVE | keys}


def test_tiles_get_the_samples_that_they_need(box: dict[str, Any], device: Device) -> None:
    scene = described(strip(box))
    film, series, _ = drive(Renderer(scene, device), scene, lambda *_: None)
    errors = np.sqrt(tiles(film.variance()[..., 0])) / film.mean_luminance()
    # By the tile's own variances, known to some √(2 / 1024 pixels) of themselves at most.
    assert 0.018 < errors[0, 1] < 0.02 * (1 + np.sqrt(2) / TILE)
    assert (errors[0, [0, 2]] == 0).all()
    noisy = slice(TILE, 2 * TILE)
    assert film.count[:, noisy].min() > 3 * PILOT
    assert (np.delete(film.count, np.s_[noisy], axis=1) == PILOT).all()
    assert film.mean_samples < 0.6 * film.count.max(), "a uniform picture of this error takes more"
    assert series[-1]["samples"] == film.mean_samples
    assert outcome(scene.stop, film, 1.0)["met"]


def test_the_picture_is_a_function_of_scene_and_contract(box: dict[str, Any], device: Device) -> None:
    """However its rounds are cut into ranges: the same decisions, the same picture. It can be rendered again."""
    scene = described(strip(box, relative_error=0.015))
    renderer, films = Renderer(scene, device), list[Film]()
    for size in (5, 1000):
        film = Film.empty(scene.film.width, scene.film.height, renderer.names)
        while pieces := next_round(scene.stop, film):
            for piece in pieces:
                for first in range(piece.start, piece.stop, size):
                    film = film.merge(renderer.render(first, min(first + size, piece.stop), piece.pixels))
        films.append(film)
    assert np.array_equal(films[0].count, films[1].count)
    assert films[0].ranges == films[1].ranges
    assert np.allclose(films[0].mean, films[1].mean, rtol=1e-12, atol=0)


def test_adaptive_pictures_have_the_mean_of_uniform_ones(box: dict[str, Any], device: Device) -> None:
    """Over many seeds, by Welch's test; and their variances are those of their differences."""
    noisy = np.s_[:, TILE : 2 * TILE]
    adaptive, uniform, said = [], [], []
    for seed in range(32):
        scene = described(strip(box, statistics.seed(seed), relative_error=0.05))
        film, *_ = drive(Renderer(scene, device), scene, lambda *_: None)
        adaptive.append(film.mean[noisy].mean())
        said.append(film.variance()[noisy].sum() / TILE**4)
        long = strip(box, statistics.seed(1000 + seed))
        uniform.append(Renderer(described(long), device).render(0, 64).mean[noisy].mean())
    statistics.accept(float(ttest_ind(adaptive, uniform, equal_var=False).pvalue), "adaptive against uniform")
    freedom = len(adaptive) - 1
    statistics.accept_squares(freedom * np.var(adaptive, ddof=1) / np.mean(said), freedom, "between seeds")


def test_a_picture_may_have_one_pixel(box: dict[str, Any], device: Device) -> None:
    scene = described(strip(box) | {"film": {"width": 1, "height": 1}})
    film, *_ = drive(Renderer(scene, device), scene, lambda *_: None)
    assert outcome(scene.stop, film, 1.0)["met"]
    assert film.samples > 3 * PILOT


def test_without_noise_a_contract_takes_its_pilot(box: dict[str, Any], device: Device) -> None:
    keys: dict[str, Any] = {"integrator": {"kind": "transmittance"}}
    scene = described(strip(box) | keys)
    film, *_ = drive(Renderer(scene, device), scene, lambda *_: None)
    assert film.samples == PILOT
    assert outcome(scene.stop, film, 1.0)["met"]
