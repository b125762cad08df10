"""Error against time: of streams whose law is known the slope's band holds it as often as it says, and what is wrong
is flagged, where it can be known."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
import pytest
from scipy.stats import binom, t
from tests.conftest import Rng
from tests.statistics import accept

from woodcock.convergence import Curve, _averaging, slope
from woodcock.film import Film
from woodcock.reference import Reference
from woodcock.regression import fit, quantile
from woodcock.series import SERIES_GROWTH, Point, against, due, efficiency, measure
from woodcock.space import Array

Draw = Callable[[np.random.Generator, tuple[int, ...]], Array]

#: Samples of mean 1. Those that are clamped have less; those of a tail of index 3/2 have no variance.
DRAWS: dict[str, Draw] = {
    "normal": lambda random, shape: random.normal(1, 1, shape),
    "exponential": lambda random, shape: random.exponential(1, shape),
    "rare": lambda random, shape: 20.0 * (random.random(shape) < 0.05),
    "clamped": lambda random, shape: np.minimum(random.exponential(1, shape), 2),
    "Pareto": lambda random, shape: (1 - random.random(shape)) ** (-1 / 1.5) / 3,
}


def counts(points: int, first: int = 2) -> list[int]:
    """Samples at the points of a series."""
    found = [first]
    while len(found) < points:
        found.append(math.ceil(found[-1] * SERIES_GROWTH))
    return found


def streams(
    random: np.random.Generator,
    draw: str,
    points: int,
    runs: int,
    pixels: int = 64,
    truth: float | None = 1.0,
    noise: float | None = None,
) -> list[list[Point]]:
    """Series of renders, every pixel of the same law. truth: of the reference, if there is one; noise: its variance."""
    mean, m2, held = np.zeros((runs, pixels)), np.zeros((runs, pixels)), 0
    reference = None if truth is None else truth + math.sqrt(noise or 0.0) * random.standard_normal((runs, pixels))
    series: list[list[Point]] = [[] for _ in range(runs)]
    for n in counts(points):
        new = DRAWS[draw](random, (n - held, runs, pixels))
        delta = new.mean(axis=0) - mean
        m2 += ((new - new.mean(axis=0)) ** 2).sum(axis=0) + delta**2 * held * (n - held) / n
        mean, held = mean + delta * (n - held) / n, n
        estimated = np.sqrt((m2 / (n * (n - 1))).mean(axis=1))
        true = None if reference is None else ((mean - reference) ** 2).mean(axis=1) - (noise or 0.0)
        for run, own in enumerate(series):
            own.append(point(n, float(estimated[run]), None if true is None else float(true[run]), noise))
    return series


def point(n: float, rmse: float, mse: float | None = None, noise: float | None = None, rate: float = 100) -> Point:
    told = {
        "mse": mse, "rel_mse": mse, "smape": 0, "bias": 0, "bias_error": 0, "flip": None, "reference_mse": noise,
    }  # fmt: skip
    found = {"seconds": n / rate, "device_seconds": n / rate, "samples": n, "rmse": rmse, "rel_mse": 0.0}
    return cast(Point, {**found, "against": None if mse is None else told})


def accept_coverage(hits: Sequence[bool], what: str) -> None:
    """Of bands of 95 %: neither fewer nor more hold the slope than chance allows."""
    law = binom(len(hits), 0.95)
    accept(2 * min(law.cdf(sum(hits)), law.sf(sum(hits) - 1)), f"{what}: {np.mean(hits):.3f}", exact=False)


# The band


@pytest.mark.parametrize(
    ("draw", "points"),
    [*itertools.product(("normal", "exponential"), (4, 14)), ("exponential", 6), ("exponential", 10), ("rare", 14)],
)
def test_bands_hold_the_slope_as_often_as_they_say(rng: Rng, draw: str, points: int) -> None:
    """Of the estimated error and of the true one, through 4 points that take 6 samples, and 14 that take 181."""
    estimated, true = [], []
    for series in streams(rng(100 + points), draw, points, runs=300):
        found = slope(series)
        own = found["against"]
        assert found["low"] is not None
        assert found["high"] is not None
        assert own is not None
        assert found["points"] == own["points"] == points
        estimated.append(found["low"] <= -0.5 <= found["high"])
        true.append(own["low"] <= -0.5 <= own["high"])
    accept_coverage(estimated, f"{draw}, {points} points, estimated")
    accept_coverage(true, f"{draw}, {points} points, true")


def test_bands_of_independent_points_would_be_too_narrow(rng: Rng) -> None:
    """What an ordinary least-squares band makes of the same series."""
    hits = []
    for series in streams(rng(7), "normal", 14, runs=300):
        n = np.array([one["samples"] for one in series])
        line = fit(np.log(n), np.log([one["rmse"] for one in series]), np.eye(len(n)))
        hits.append(abs(line.slope + 0.5) < quantile(0.05, line.freedom) * line.error)
    assert np.mean(hits) < 0.8


def test_bands_narrow_as_series_grow(rng: Rng) -> None:
    """That of the true error after 14 points of 64 pixels is as narrow as errors of 71 % correlation from one point
    to the next allow: ± .05, where the shape of an average would make it twice as wide."""
    short, long = ([slope(one) for one in streams(rng(8), "normal", points, 40)] for points in (5, 14))
    narrow, wide = (np.median([found["high"] - found["low"] for found in runs]) / 2 for runs in (long, short))
    assert narrow < wide / 5
    assert np.median([own["high"] - own["low"] for found in long if (own := found["against"])]) / 2 < 0.075


def test_generalised_least_squares(rng: Rng) -> None:
    """The error that it tells is that of slopes through points of the covariance it was given, and so is the factor."""
    n, random = np.array([2.0, 3, 5, 8, 20]), rng(9)
    shape = _averaging(n)
    noise = 0.3 * random.standard_normal((1500, 5)) @ np.linalg.cholesky(shape).T
    lines = [fit(np.log(n), 2 - np.log(n) + one, shape) for one in noise]
    scores = np.array([(line.slope + 1) / line.error for line in lines])
    accept(float(t(3).sf(abs(scores.mean()) * math.sqrt(len(scores)) / math.sqrt(3))), "mean", exact=False)
    accept_coverage([bool(abs(score) < t(3).isf(0.025)) for score in scores], "Student's law")
    assert np.mean([line.scale**2 for line in lines]) == pytest.approx(0.09, rel=0.12)


@pytest.mark.parametrize("freedom", [1, 2, 3, 8, 33])
@pytest.mark.parametrize("level", [0.05, 1e-4])
def test_quantiles_of_student_s_law(level: float, freedom: int) -> None:
    assert quantile(level, freedom) == pytest.approx(t(freedom).isf(level / 2), rel=1e-9)


# Verdicts


def flagged(series: list[list[Point]], says: str = "") -> float:
    found = [slope(one) for one in series]
    return float(np.mean([one["verdict"] == "flagged" and one["says"].startswith(says) for one in found]))


@pytest.mark.parametrize("draw", ["normal", "exponential", "rare"])
@pytest.mark.parametrize("points", [4, 8, 13])
def test_what_is_well_is_not_flagged(rng: Rng, draw: str, points: int) -> None:
    series = streams(rng(points), draw, points, runs=60, pixels=256)
    assert flagged(series) == 0
    if points > 6:
        assert {slope(one)["verdict"] for one in series} == {"as expected"}


def test_samples_without_a_variance_are_flagged(rng: Rng) -> None:
    """A tail of index 3/2, with a reference and without."""
    for truth in (None, 1.0):
        assert flagged(streams(rng(11), "Pareto", 13, runs=60, truth=truth)) > 0.8
    assert flagged(streams(rng(12), "Pareto", 13, runs=60, truth=None), "Heavy tail") > 0.8


def test_a_bias_is_flagged_by_a_reference_alone(rng: Rng) -> None:
    """Exponential samples clamped at 2 lack e⁻² of the mean: the samples themselves look better than ever."""
    assert flagged(streams(rng(13), "clamped", 13, runs=60), "Bias") == 1
    assert flagged(streams(rng(13), "clamped", 13, runs=60, truth=None)) == 0
    own = slope(streams(rng(13), "clamped", 13, runs=1)[0])["against"]
    assert own is not None
    assert own["low"] > -0.5


def test_a_noisy_reference_is_no_bias(rng: Rng) -> None:
    """Of the variance of 30 samples; without what it states of itself it would be one."""
    known = streams(rng(14), "normal", 13, runs=60, noise=1 / 30)
    assert flagged(known) == 0
    assert {own["points"] for one in known if (own := slope(one)["against"])} < set(range(4, 12))
    silent = [[hidden(one) for one in series] for series in known]
    assert flagged(silent, "Bias") > 0.9


def hidden(one: Point) -> Point:
    """A point against the same reference, of unknown noise."""
    assert one["against"] is not None
    return point(one["samples"], one["rmse"], one["against"]["mse"] + 1 / 30)


def test_a_device_that_changes_its_speed_is_no_bias() -> None:
    """Ten times as fast after 16 samples: over time the error falls faster than it should."""
    wave = itertools.cycle((1.001, 0.999))
    series, seconds = [], 0.0
    for before, n in itertools.pairwise([0, *counts(12)]):
        seconds += (n - before) / (100 if n < 16 else 1000)
        series.append(point(n, next(wave) / math.sqrt(n), rate=n / seconds))
    found = slope(series)
    assert found["verdict"] == "as expected"
    assert "devices did not work at one speed" in found["says"]
    assert found["slope"] is not None
    assert found["slope"] < -0.55


@pytest.mark.parametrize("power", [-0.3, -0.8])
def test_a_slope_that_is_off_is_flagged(power: float) -> None:
    wave = itertools.cycle((1.001, 0.999))
    found = slope([point(n, next(wave) * n**power) for n in counts(12)])
    assert found["verdict"] == "flagged"
    assert found["slope"] == pytest.approx(power, abs=0.01)


def test_what_is_not_known() -> None:
    none = slope([])
    assert (none["slope"], none["low"], none["high"], none["points"], none["against"]) == (None, None, None, 0, None)
    for series in ([], [point(2, 1), point(4, 0.7)], [point(2, 0.0), point(4, 0.7), point(8, 0.5)]):
        assert slope(series)["verdict"] == "not known"
    wild = slope([point(2, 1), point(4, 0.3), point(8, 0.7), point(16, 0.1)])
    assert (wild["verdict"], wild["points"]) == ("not known", 4)
    series = [point(n, 1 / math.sqrt(n)) for n in counts(8)]
    assert slope(series)["verdict"] == "as expected"
    assert slope(series, uniform=False)["verdict"] == "not known"


def test_points_that_add_nothing_are_left() -> None:
    series = [point(n, 1 / math.sqrt(n)) for n in counts(8)]
    assert slope([*series, series[-1]]) == slope(series)


# Points


def film(n: int = 4, mean: float = 2.0, variance: float = 0.01, channels: int = 1, **keys: Any) -> Film:
    """Every channel of 16 × 8 pixels has that mean and that variance of it."""
    shape = (8, 16, channels)
    m2 = np.full(shape, variance * n * (n - 1))
    names = ("Y",) if channels == 1 else ("R", "G", "B")
    return Film(np.full(shape[:2], n, np.uint32), np.full(shape, mean), m2, names, ((0, n),), **keys)


def test_a_point_says_what_the_samples_tell() -> None:
    found = measure(film(), 3.0, 2.0, None)
    assert found == {
        "seconds": 3.0, "device_seconds": 2.0, "samples": 4.0, "rmse": pytest.approx(0.1),
        "rel_mse": pytest.approx(0.01 / (4 * 1.01)), "against": None,
    }  # fmt: skip


def test_there_is_no_point_before_the_error_is_known_or_without_noise() -> None:
    assert measure(film(n=1), 1.0, 1.0, None) is None
    assert measure(film(bound=np.zeros((8, 16, 1))), 1.0, 1.0, None) is None


def test_points_are_geometric() -> None:
    last = measure(film(n=10), 1.0, 1.0, None)
    assert last is not None
    assert due([], film(n=1))
    assert not due([last], film(n=14))
    assert due([last], film(n=15))


@pytest.mark.parametrize("channels", [1, 3])
def test_against_a_reference(channels: int) -> None:
    truth = Reference(np.full((8, 16, 3), 1.5), np.full((8, 16, 3), 0.04), "long.exr")
    found = against(film(channels=channels), truth)
    assert found["mse"] == pytest.approx(0.25 - 0.04)
    assert found["rel_mse"] == pytest.approx((0.25 - 0.04) / (2.25 * 1.01))
    assert found["smape"] == pytest.approx(0.5 / 3.5)
    assert found["bias"] == pytest.approx(0.5)
    assert found["bias_error"] == pytest.approx(math.sqrt(0.05 / 128))
    assert found["reference_mse"] == pytest.approx(0.04)


def test_against_an_exact_reference() -> None:
    truth = Reference(np.full((8, 16, 1), 1.5), None, "exact.exr")
    found = against(film(), truth)
    assert (found["mse"], found["reference_mse"]) == (pytest.approx(0.25), None)
    assert found["bias_error"] == pytest.approx(math.sqrt(0.01 / 128))
    assert against(film(n=1), truth)["bias_error"] is None


def test_flip_has_a_tenth_of_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the points are, all of those that have it together; and always at the end."""
    monkeypatch.setattr("woodcock.metrics.flip", lambda *pictures: 0.5)
    monkeypatch.setattr("woodcock.metrics.FLIP_SECONDS", 1 / 2 / 128)  # a second each, of two exposures
    truth, seconds, spent = Reference(np.full((8, 16, 1), 1.5), None, "exact.exr"), 1.0, 0
    while seconds < 1000:
        seconds *= SERIES_GROWTH
        found = measure(film(), seconds, seconds, truth)
        assert found is not None
        assert found["against"] is not None
        spent += found["against"]["flip"] is not None
        assert spent <= seconds / 10
    assert spent > 5
    assert against(film(), truth)["flip"] == 0.5


def test_efficiency() -> None:
    """Half of the variance or half of the time are worth the same."""
    assert efficiency(film(), 2.0) == pytest.approx(1 / (0.01 * 2))
    assert efficiency(film(variance=0.005), 4.0) == pytest.approx(efficiency(film(), 2.0))
    for unknown in (film(n=1), film(variance=0), film(bound=np.ones((8, 16, 1)))):
        assert efficiency(unknown, 2.0) is None


def test_a_curve_is_fitted_over_what_one_asks() -> None:
    n = np.array([2.0, 4, 8])
    curve = Curve(n, n**2, 1 / n, _averaging(n))
    assert curve.over(curve.samples).slope == pytest.approx(-1)
    assert curve.over(curve.seconds).slope == pytest.approx(-0.5)
