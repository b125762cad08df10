"""Metrics against sums by hand, against what is known of samples, and FLIP against what its paper says of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.conftest import Rng
from tests.statistics import accept_z

from woodcock import flip, metrics
from woodcock.film import LUMINANCE
from woodcock.space import Array

RED = np.array([[[1.0, 0.0, 0.0]]])
FLIP = pytest.mark.skipif(flip.flip_evaluator is None, reason="pip install flip-evaluator")


def grey(*values: float) -> Array:
    """A row of pixels."""
    return np.array(values).reshape(1, -1, 1)


def test_mean_square_error() -> None:
    assert metrics.mse(grey(1, 2, 5), grey(1, 4, 1)) == pytest.approx((0 + 4 + 16) / 3)
    assert metrics.mse(RED, 0 * RED) == pytest.approx(0.2126)


def test_the_reference_s_noise_is_subtracted() -> None:
    assert metrics.mse(grey(1, 2), grey(1, 4), grey(0.5, 1.5)) == pytest.approx(2 - 1)
    assert metrics.mse(grey(1, 2), grey(1, 2), grey(0.5, 1.5)) == 0
    over = np.array([1, 16]) + 0.01 * 2.5**2
    expected = np.mean(np.array([4 - 0.5, 4 - 1.5]) / over)
    assert metrics.rel_mse(grey(3, 2), grey(1, 4), grey(0.5, 1.5)) == pytest.approx(expected)


def test_relative_mean_square_error() -> None:
    """ε is a hundredth of the squared mean luminance, 2 here: of a black pixel, the error counts as over .2."""
    assert metrics.rel_mse(grey(1, 0), grey(0, 4)) == pytest.approx((1 / 0.04 + 16 / 16.04) / 2)
    assert metrics.rel_mse(grey(0, 0), grey(0, 0)) == 0
    assert metrics.rel_mse(grey(0, 1), grey(0, 0)) > 1e300


@pytest.mark.parametrize("scale", [1e-20, 1, 1e20])
def test_relative_errors_have_no_unit(scale: float) -> None:
    random = np.random.default_rng(1)
    picture, reference, variance = random.random((3, 4, 5, 3))
    for found, expected in (
        (
            metrics.rel_mse(scale * picture, scale * reference, scale**2 * variance / 100),
            metrics.rel_mse(picture, reference, variance / 100),
        ),
        (metrics.smape(scale * picture, scale * reference), metrics.smape(picture, reference)),
        (metrics.estimated_rel_mse(scale * picture, scale**2 * variance), metrics.estimated_rel_mse(picture, variance)),
    ):
        assert expected > 0
        assert found == pytest.approx(expected)


def test_symmetric_mean_absolute_percentage_error() -> None:
    assert metrics.smape(grey(1, 0, 0, 3), grey(3, 0, 2, 3)) == pytest.approx((0.5 + 0 + 1 + 0) / 4)


def test_bias_and_its_error() -> None:
    assert metrics.bias(grey(1, 2), grey(1, 4)) == -1
    assert metrics.bias_error(grey(1, 4), grey(4, 0)) == pytest.approx(math.sqrt(1 + 4 + 4) / 2)
    # Channels may err together: their deviations add, where independent ones would add as squares.
    assert metrics.bias_error(np.full((1, 1, 3), 4.0)) == pytest.approx(2)


def test_the_estimate_without_a_reference_is_the_error_with_one(rng: Rng) -> None:
    """Of exponential samples around means from .01 to 1: a pixel's variance is μ² / n."""
    n, truth = 400, np.geomspace(0.01, 1, 16).reshape(1, -1, 1)
    samples = truth * rng(3).exponential(size=(n, 2000, 16, 1))
    mean, variance = samples.mean(axis=0), samples.var(axis=0, ddof=1) / n
    exact = float(np.mean(truth**2 / n / (truth**2 + metrics.epsilon(np.broadcast_to(truth, mean.shape)))))
    found = metrics.estimated_rel_mse(mean, variance)
    assert found == pytest.approx(exact, rel=3 * exact)
    true = [metrics.rel_mse(row[None], truth) for row in mean]
    accept_z((np.mean(true) - exact) / (np.std(true, ddof=1) / math.sqrt(len(true))))


def test_fireflies_count_for_too_little_without_a_reference() -> None:
    """One sample of 64 is 6400, the others are 1: its pixel counts as 1 at most."""
    samples = np.where(np.arange(64) == 5, 6400.0, 1.0).reshape(64, 1, 1, 1)
    mean, variance = samples.mean(axis=0), samples.var(axis=0, ddof=1) / 64
    assert 0.9 < metrics.estimated_rel_mse(mean, variance) < 1
    assert metrics.rel_mse(mean, grey(1)) > 1000


def test_error_against_a_noisy_reference(rng: Rng) -> None:
    """What is subtracted leaves the error against the truth."""
    random, pixels = rng(5), (400, 50, 50, 1)
    picture, reference = 3 + 0.1 * random.standard_normal(pixels), 3 + 0.05 * random.standard_normal(pixels)
    found = [metrics.mse(*pair, np.full(pixels[1:], 0.05**2)) for pair in zip(picture, reference, strict=True)]
    accept_z((np.mean(found) - 0.01) / (np.std(found, ddof=1) / math.sqrt(len(found))))


def scenery(scale: float = 1.0) -> Array:
    """A picture with something bright, of three stops and more."""
    y, x = np.mgrid[0:24, 0:32]
    light = 0.2 + np.exp(-((x - 10) ** 2 + (y - 8) ** 2) / 20) * 3
    return np.asarray(scale * light[..., None] * np.array([1, 0.8, 0.6]))


@FLIP
def test_flip_of_identical_pictures_is_0() -> None:
    assert metrics.flip(scenery(), scenery()) == 0


@FLIP
def test_flip_grows_with_the_error_and_stays_below_1() -> None:
    noise = np.random.default_rng(2).standard_normal(scenery().shape)
    values = [metrics.flip(scenery() + amount * noise, scenery()) for amount in (0.01, 0.1, 1.0, 1e9)]
    assert all(value is not None for value in values)
    assert 0 < values[0] < values[1] < values[2] < values[3] <= 1  # type: ignore[operator]


@FLIP
@pytest.mark.parametrize("scale", [1e-30, 1e-6, 1e30])
def test_flip_has_no_unit(scale: float) -> None:
    """Exposures follow the reference."""
    expected = metrics.flip(1.2 * scenery(), scenery())
    assert metrics.flip(1.2 * scenery(scale), scenery(scale)) == pytest.approx(expected, rel=1e-4)


@FLIP
def test_flip_of_black_and_white() -> None:
    """Ebelin & Akenine-Möller (2021): the largest error there is, of white against black, is near 1."""
    white = np.ones((16, 16, 1))
    assert metrics.flip(0 * white, white) == pytest.approx(0.965, abs=0.01)


@FLIP
def test_flip_takes_grey_as_three_equal_channels() -> None:
    shade = scenery()[..., :1]
    colour = np.repeat(shade, 3, axis=2)
    assert metrics.flip(1.1 * shade, shade) == metrics.flip(1.1 * colour, colour)


@FLIP
def test_flip_is_what_the_package_says() -> None:
    """By its own choice of exposures, of a picture whose median it can tell."""
    reference = scenery().astype(np.float32)
    reference /= float((reference @ LUMINANCE).max())
    test = np.float32(1.3) * reference
    _, expected, chosen = flip.flip_evaluator.evaluate(reference, test, "HDR", applyMagma=False)
    assert chosen["stopExposure"] - chosen["startExposure"] == pytest.approx(metrics.flip_stops(reference), abs=1e-3)
    assert metrics.flip(test, reference) == pytest.approx(expected, rel=1e-4)


@FLIP
def test_flip_of_a_mostly_black_picture() -> None:
    """The median of what is not black ends the exposures, where all pixels' would have no logarithm."""
    picture = np.zeros((16, 16, 1))
    picture[2:4, 2:4] = np.array([1, 2, 4, 8]).reshape(2, 2, 1)
    assert metrics.flip_stops(picture) == pytest.approx(math.log2(8 / 3))
    assert metrics.flip(picture, picture) == 0
    assert metrics.flip(picture, 0 * picture) is None
    assert metrics.flip_seconds(0 * picture) == 0


@FLIP
def test_flip_in_a_process_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = metrics.flip_errors(1.3 * scenery(), scenery())
    monkeypatch.setattr(flip, "SHORT", 0.0)
    monkeypatch.setattr(flip, "_evaluated", None)  # not in this one
    found = metrics.flip_errors(1.3 * scenery(), scenery())
    assert found is not None
    assert expected is not None
    np.testing.assert_array_equal(found, expected)
    monkeypatch.setattr("sys.executable", "/bin/false")
    assert metrics.flip(scenery(), scenery()) is None


def test_flip_where_it_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flip, "flip_evaluator", None)
    assert metrics.flip(scenery(), scenery()) is None
