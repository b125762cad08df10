"""Noise or bias: verdicts on made pictures of which it is known, z-scores against their law."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.conftest import Rng
from tests.statistics import accept_z

from woodcock.compare.noise import coherence, judge, z_scores
from woodcock.compare.rendered import Rendered
from woodcock.film import Film
from woodcock.image import ImageError, write_exr
from woodcock.space import Array

SHAPE = (48, 64, 3)
#: Of a picture with edges and a slope.
Y, X = np.mgrid[0 : SHAPE[0], 0 : SHAPE[1]] / 16
TRUTH = (0.5 + 0.2 * Y + np.where((X - 2) ** 2 + (Y - 1.5) ** 2 < 1, 1.0, 0.0))[..., None] * np.array([1, 0.7, 0.4])


def rendered(random: np.random.Generator, truth: Array = TRUTH, seed: int = 1, samples: int = 64) -> Rendered:
    """As if each sample were normal, of half the truth's size; channels share their paths."""
    noise = random.standard_normal((samples, *truth.shape[:2], 1)) + 0.1 * random.standard_normal(
        (samples, *truth.shape)
    )
    values = truth * (1 + 0.5 * noise)
    mean, variance = values.mean(axis=0), values.var(axis=0, ddof=1) / samples
    return Rendered(mean, variance, seed=seed, ranges=((0, samples),), samples=samples)


def test_z_scores_of_independent_noise_are_normal(rng: Rng) -> None:
    random = rng(1)
    picture, reference = rendered(random), rendered(random, seed=2, samples=256)
    scores = z_scores(picture, reference)
    assert scores is not None
    off = picture.mean - reference.mean
    assert picture.variance is not None
    assert reference.variance is not None
    assert np.allclose(scores, off / np.sqrt(picture.variance + reference.variance), rtol=1e-6)
    pixels = scores[..., 0].size
    verdict = judge(picture, reference)
    scatter = verdict["scatter"]
    assert scatter is not None
    assert scatter["beyond_2"] == np.mean(np.abs(scores) > 2)
    assert scatter["beyond_3"] == np.mean(np.abs(scores) > 3)
    assert scatter["mean_square"] == pytest.approx(np.mean(scores**2))
    # Channels of a pixel count as one; Student's t with 63 degrees of freedom and more has .0500 beyond 2 at most.
    accept_z((scatter["beyond_2"] - 0.0465) / math.sqrt(0.0465 * 0.9535 / pixels), exact=False)
    accept_z((scatter["mean_square"] - 1.01) / scatter["error"], exact=False)
    assert scatter["pixels"] == 1
    assert verdict["kind"] == "noise", verdict
    assert verdict["says"].startswith("Noise: the means of the whole and of 16 parts agree to ")
    assert verdict["bias_error"] is not None
    assert verdict["detectable"] == pytest.approx(verdict["limit"] * verdict["bias_error"])


def test_a_picture_that_is_darker_is_biased(rng: Rng) -> None:
    random = rng(2)
    verdict = judge(rendered(random, 0.98 * TRUTH), rendered(random, seed=2))
    assert verdict["kind"] == "bias", verdict
    assert verdict["says"].startswith("Bias: the picture is darker by ")
    whole, *parts = verdict["parts"]
    assert (whole["x"], whole["y"], whole["width"], whole["height"]) == (0, 0, 64, 48)
    assert len(parts) == 16
    assert [parts[5][key] for key in ("x", "y", "width", "height")] == [16, 12, 16, 12]  # type: ignore[literal-required]


def test_a_part_that_is_brighter_is_named(rng: Rng) -> None:
    random, changed = rng(3), TRUTH.copy()
    changed[12:24, 48:] *= 1.1
    changed[24:36, :16] *= 0.9
    says = judge(rendered(random, changed), rendered(random, seed=2))["says"]
    assert says.startswith("Bias: a part of the picture (from pixel ")
    assert "(from pixel 48, 12, 16 × 12) is brighter by" in says or "(from pixel 0, 24, 16 × 12) is darker by" in says


def test_what_differs_in_detail_is_biased_though_the_means_agree(rng: Rng) -> None:
    """Fine stripes are only in the picture."""
    random = rng(4)
    picture, reference = rendered(random), rendered(random, seed=2)
    striped = replace(picture, mean=picture.mean + 0.15 * np.sin(40 * X + 40 * Y)[..., None])
    verdict = judge(striped, reference)
    assert verdict["kind"] == "bias", verdict
    assert "differences of neighbouring pixels go together" in verdict["says"]
    assert verdict["coherence_deviation"] is not None
    assert abs(verdict["coherence_deviation"]) > verdict["limit"]


def test_coherence_is_a_correlation_with_its_error(rng: Rng) -> None:
    """Of noise of whatever size, pixel by pixel."""
    random = rng(5)
    sizes = np.exp(random.standard_normal((48, 64)))
    found = [coherence(sizes * random.standard_normal((48, 64))) for _ in range(100)]
    accept_z(np.mean([one.deviation for one in found]) * math.sqrt(100), exact=False)
    assert 0.6 < np.std([one.deviation for one in found]) < 1.4
    assert coherence(np.ones((4, 4))).correlation == pytest.approx(1)
    assert coherence(np.zeros((4, 4))) == (0, 0)
    assert coherence(np.ones((1, 1))) == (0, 0)


def test_pictures_that_share_random_numbers_have_no_z_scores(rng: Rng) -> None:
    picture = rendered(rng(6))
    more = replace(rendered(rng(7)), ranges=((0, 128),))
    assert picture.shares_with(more)
    assert z_scores(picture, more) is None
    verdict = judge(picture, more)
    assert (verdict["shared"], verdict["scatter"]) == (True, None)
    assert verdict["kind"] == "noise", verdict
    off = (picture.mean - more.mean) @ np.array([0.2126, 0.7152, 0.0722])
    assert verdict["bias_error"] == pytest.approx(math.sqrt(float(np.sum(off**2))) / off.size)
    darker = replace(more, mean=0.999 * picture.mean)  # the same noise: far below what variances could tell
    assert judge(darker, picture)["kind"] == "bias"


@pytest.mark.parametrize(
    ("mine", "its", "shared"),
    [
        ({"seed": 1}, {"seed": 2}, False),
        ({"seed": 1}, {"seed": 1}, True),
        ({"seed": None}, {"seed": 1}, True),
        ({"seed": 1, "ranges": ((0, 64),)}, {"seed": 1, "ranges": ((64, 128),)}, False),
        ({"seed": 1, "ranges": ()}, {"seed": 1}, True),
        ({"seed": 1, "bound": np.zeros(SHAPE)}, {"seed": 1}, False),
    ],
)
def test_which_pictures_share_random_numbers(mine: dict[str, object], its: dict[str, object], shared: bool) -> None:
    one = Rendered(TRUTH, TRUTH, seed=1, ranges=((0, 64),))
    assert replace(one, **mine).shares_with(replace(one, **its)) is shared  # type: ignore[arg-type]


def test_the_same_picture_is_the_same() -> None:
    picture = Rendered(TRUTH, 0.01 * TRUTH, seed=1, ranges=((0, 64),))
    verdict = judge(replace(picture, mean=TRUTH * (1 + 1e-6)), picture)
    assert verdict["kind"] == "same"
    assert "They share their random numbers" in verdict["says"]
    black = replace(picture, mean=0 * TRUTH, variance=0 * TRUTH, seed=2)
    assert judge(black, replace(black, seed=1))["kind"] == "same"
    assert "is darker than" not in judge(picture, black)["says"]


def test_pictures_without_noise_differ_by_their_bounds() -> None:
    bound = np.full(SHAPE, 1e-3)
    exact = Rendered(TRUTH, 0 * TRUTH, bound, 1, ((0, 16),), 16)
    assert z_scores(exact, exact) is None
    assert judge(replace(exact, mean=TRUTH + 1.9e-3), exact)["kind"] == "same"
    verdict = judge(replace(exact, mean=TRUTH + 2.1e-3, samples=64), exact)
    assert verdict["kind"] == "bias"
    assert "100 % of the pixels" in verdict["says"]
    assert "Samples smooth edges" in verdict["says"]
    assert (verdict["scatter"], verdict["bias_error"]) == (None, None)


def test_noise_is_held_against_a_picture_without(rng: Rng) -> None:
    exact = Rendered(TRUTH, 0 * TRUTH, np.full(SHAPE, 1e-6), 1, ((0, 16),), 16)
    assert judge(rendered(rng(8)), exact)["kind"] == "noise"
    assert judge(rendered(rng(8), 1.02 * TRUTH), exact)["kind"] == "bias"
    far = replace(exact, bound=0.03 * TRUTH)
    assert judge(rendered(rng(8), 1.02 * TRUTH), far)["kind"] == "noise", "it may be off by as much"


def test_missing_fireflies_are_no_bias(rng: Rng) -> None:
    """Of a hundred thousand samples one is a hundred thousand times as bright: half of the light. The picture, of 49
    thousand in all, has seen none; the reference has that many in each pixel."""
    random, ones, many = rng(9), np.ones((*SHAPE[:2], 1)), 1 << 16
    picture = rendered(random, ones, samples=16)
    found, bright = random.poisson(many / 1e5, ones.shape), 1e5 / many
    reference = Rendered(ones + found * bright, found * bright**2 + 0.25 / many, None, 2, ((0, many),), many)
    verdict = judge(picture, reference)
    assert verdict["kind"] == "unclear", verdict
    assert "rare bright samples" in verdict["says"]


def test_pixels_that_scatter_more_than_their_variances_say(rng: Rng) -> None:
    """Too small in every other pixel, too large in those between: right on average."""
    random = rng(10)
    picture, reference = rendered(random), rendered(random, seed=2)
    assert picture.variance is not None
    assert reference.variance is not None
    uneven = np.where(np.indices(SHAPE[:2]).sum(axis=0) % 2, 0.05, 1.95)[..., None]
    verdict = judge(
        replace(picture, variance=uneven * picture.variance), replace(reference, variance=uneven * reference.variance)
    )
    assert verdict["kind"] == "unclear", verdict
    assert "mean z² is" in verdict["says"]


def test_a_picture_is_read_with_what_its_file_says(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    mean, m2 = 1 + random.random(SHAPE), 40 * random.random(SHAPE)
    film = Film(np.full(SHAPE[:2], 20, np.uint32), mean, m2, ("R", "G", "B"), ((0, 20),))
    header = {"seed": "7", "sampleRanges": "[[0, 20]]", "samples": "20"}
    write_exr(tmp_path / "a.exr", film, header)
    found = Rendered.load(tmp_path / "a.exr")
    assert np.allclose(found.mean, mean, rtol=1e-6)
    assert found.variance is not None
    assert np.allclose(found.variance, film.variance(), rtol=1e-6)
    assert (found.bound, found.seed, found.ranges, found.samples) == (None, 7, ((0, 20),), 20)
    write_exr(tmp_path / "b.exr", replace(film, bound=np.full(SHAPE, 0.5)), header)
    bound = Rendered.load(tmp_path / "b.exr").bound
    assert bound is not None
    assert (bound == 0.5).all()
    write_exr(tmp_path / "c.exr", replace(film, count=np.ones(SHAPE[:2], np.uint32)), {})
    bare = Rendered.load(tmp_path / "c.exr")
    assert (bare.variance, bare.seed, bare.ranges, bare.samples) == (None, None, (), None)
    mean[1, 2, 0] = np.inf
    write_exr(tmp_path / "d.exr", replace(film, mean=mean), header)
    with pytest.raises(ImageError, match=r"pixel \(2, 1\) is no finite number"):
        Rendered.load(tmp_path / "d.exr")


def test_grey_counts_as_three_equal_channels() -> None:
    grey, colour = Rendered(TRUTH[..., :1], TRUTH[..., :1]), Rendered(TRUTH, None)
    wide = grey.beside(colour)
    assert wide.variance is not None
    assert (wide.mean == TRUTH[..., :1]).all()
    assert wide.mean.shape == wide.variance.shape == SHAPE
    assert colour.beside(grey).mean.shape == SHAPE
    with pytest.raises(ImageError, match="64 × 48 and 32 × 48 pixels cannot be compared"):
        grey.beside(Rendered(TRUTH[:, :32], None))
