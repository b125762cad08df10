"""What a report says of errors: of noise, of a bound, of a series that was cut; and that its schema describes it."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest
from pydantic import ValidationError

from woodcock.film import Film
from woodcock.layers import beauty_names
from woodcock.leanness import Contents
from woodcock.reference import Reference
from woodcock.report import Use, build, header
from woodcock.report_schema import Report
from woodcock.scene import Scene
from woodcock.series import Point, measure

COUNT = np.full((2, 3), 10, np.uint32)


def film(names: tuple[str, ...] = ("Y",), bound: float | None = None) -> Film:
    """Every channel is 2 with a variance of 0.01 of its mean."""
    mean, m2 = np.full((2, 3, len(names)), 2.0), np.full((2, 3, len(names)), 0.9)
    bounds = None if bound is None else np.full((2, 3, 1), bound)
    return Film(COUNT, mean, m2, names, ((0, 10),), bound=bounds)


PROGRAM: Contents = {
    "source_lines": 2, "bytes": 99, "remained": {"core/rng.h": 2}, "left_out": {"core/box.h": 7},
    "binary_bytes": None, "private_bytes": 0, "registers": None,
}  # fmt: skip
SECONDS = {"render": 4.0, "merge": 0.5, "check": 0.25, "write": 0.125}
SCENE = Scene.model_validate(
    {
        "camera": {"kind": "spherical", "origin": [0, 0, 0], "target": [0, 0, 1]},
        "surfaces": [{"kind": "sphere", "center": [0, 0, 2], "radius": 1}],
        "film": {"width": 3, "height": 2},
        "stop": {"kind": "samples", "samples": 10},
    }
)


def use(norm: float | None = None, unscattered: float | None = None, **keys: Any) -> Use:
    given = {
        "samples": 10, "render_seconds": 3.0, "program_hash": "a", "programs": {"a": 10.0}, "kinds": {}, "norm": norm,
        "evidence": None,
        "id": "cpu0", "name": "x", "driver": "1", "precision": "float", "kind": "cpu", "platform": "p", "lanes": 8,
        "platform_version": "2", "version": "3", "media": [], "program": PROGRAM,
        "unscattered": unscattered, "seconds": {"read": 0.0, "build": 0.0, "upload": 0.0},
    }  # fmt: skip
    return cast(Use, given | keys)


def report(
    film: Film,
    norm: float | None = None,
    unscattered: float | None = None,
    series: Sequence[Point] = (),
    reference: Reference | None = None,
) -> dict[str, Any]:
    """As its schema describes it."""
    built = build(film, [use(norm, unscattered)], series, SECONDS, scene=SCENE, reference=reference)
    said = json.loads(json.dumps(built, allow_nan=False))
    Report.model_validate(said)
    return cast(dict[str, Any], said)


def test_noise() -> None:
    said = report(film())
    assert said["rmse"] == pytest.approx(0.1)
    assert said["relative_rmse"] == pytest.approx(0.05)
    assert (said["deterministic"], said["bound"], said["orders"]) == (False, None, None)


def test_a_bound_in_place_of_noise() -> None:
    """The error is at most the bound, and there is no series of it."""
    still = film(bound=0.5)
    said = report(still)
    assert said["deterministic"]
    assert said["bound"] == {"largest": 0.5, "rms": 0.5}
    assert (said["rmse"], said["relative_rmse"]) == (0.5, 0.25)
    assert said["efficiency"] is said["rel_mse"] is None
    assert (said["slope"]["slope"], said["slope"]["verdict"]) == (None, "not known")


@pytest.mark.parametrize("value", [math.inf, math.nan])
def test_a_bound_that_is_none_is_null(value: float) -> None:
    said = report(film(bound=value))
    assert said["bound"] == {"largest": None, "rms": None}
    assert said["rmse"] is said["relative_rmse"] is None


ORDERS = tuple(f"{layer}{name}" for layer in ("", "order.0.", "order.1.", "order.rest.") for name in beauty_names(3))


@pytest.mark.parametrize(
    ("norm", "unscattered", "bound"), [(0.5, 3, 1.5), (0.9, 1, 8.1), (0, 1, 0), (1, 3, None), (None, 3, None)]
)
def test_a_series_that_was_cut(norm: float | None, unscattered: float, bound: float | None) -> None:
    """The geometric series from order 2 on, beside what was measured."""
    said = report(film(ORDERS), norm, unscattered)["orders"]
    assert (said["last"], said["rest"], said["norm"]) == (1, pytest.approx(2), norm)
    assert said["rest_error"] == pytest.approx(0.1 / math.sqrt(6))
    assert said["rest_bound"] == (None if bound is None else pytest.approx(bound))


def test_a_series_without_a_bound_on_what_is_not_scattered() -> None:
    assert report(film(ORDERS), 0.5)["orders"]["rest_bound"] is None


def points(film: Film, reference: Reference | None = None) -> list[Point]:
    """Of a render whose device works for half of the time."""
    series = []
    for n in (2, 3, 5, 8, 12):
        count = np.full(film.count.shape, n, np.uint32)
        part = replace(film, count=count, m2=film.m2 / 90 * 10 * (n - 1), ranges=((0, n),))
        point = measure(part, n / 2, n / 4, reference)
        assert point is not None
        series.append(point)
    return series


def test_error_against_time() -> None:
    """Of 0.1 at 10 samples, after the 6 s that the last point says."""
    said = report(film(), series=points(film()))
    assert [one["rmse"] for one in said["error"]] == pytest.approx([0.1 * math.sqrt(10 / n) for n in (2, 3, 5, 8, 12)])
    assert (said["slope"]["slope"], said["slope"]["verdict"]) == (pytest.approx(-0.5), "as expected")
    assert said["efficiency"] == pytest.approx(1 / (0.01 * 6))
    assert said["rel_mse"] == pytest.approx(0.01 / 4.04)
    assert said["against"] is said["reference"] is None
    assert (said["samples"], said["mean_samples"]) == (10, 10.0)


def test_where_the_time_went() -> None:
    said = report(film())
    assert said["seconds"] == {"read": 0, "build": 0, "upload": 0, **SECONDS}
    assert said["utilisation"] == pytest.approx(3 / 4)
    two = build(film(), [use(), use(id="cpu1", render_seconds=1.0)], [], SECONDS, scene=SCENE)
    assert two["utilisation"] == pytest.approx((3 + 1) / (4 * 2))
    assert said["efficiency"] == pytest.approx(1 / (0.01 * 4))


def test_against_a_reference() -> None:
    truth = Reference(np.full((2, 3, 1), 1.5), None, "long.exr")
    said = report(film(), series=points(film(), truth), reference=truth)
    assert said["reference"] == "long.exr"
    assert said["against"]["mse"] == pytest.approx(0.25)
    assert [one["against"]["bias"] for one in said["error"]] == pytest.approx([0.5] * 5)
    assert said["slope"]["against"]["slope"] == pytest.approx(0, abs=1e-9)
    assert said["slope"]["verdict"] == "flagged"
    assert "convergence" in said["certificate"]["failed"]


def test_pixels_with_samples_of_their_own_have_no_slope_to_expect() -> None:
    uneven = film()
    uneven = replace(uneven, count=uneven.count + np.arange(6, dtype=np.uint32).reshape(2, 3))
    assert report(uneven, series=points(film()))["slope"]["verdict"] == "not known"
    assert report(uneven)["mean_samples"] == 12.5


def test_the_contract() -> None:
    assert report(film())["contract"]["met"]
    assert "contract" not in report(film())["certificate"]["failed"]
    short = replace(film(), ranges=((0, 9),))
    assert not report(short)["contract"]["met"]
    assert "contract" in report(short)["certificate"]["failed"]


def test_every_number_is_described() -> None:
    """Nothing is in a report that its schema does not name, and nothing that it names is missing."""
    said = report(film(ORDERS), 0.5, 3, points(film()), Reference(np.full((2, 3, 1), 1.5), None, "long.exr"))
    for change in (said | {"fog": 1}, {key: value for key, value in said.items() if key != "slope"}):
        with pytest.raises(ValidationError):
            Report.model_validate(change)
    models = Report.model_json_schema()["$defs"] | {"Report": Report.model_json_schema()}
    bare = [
        f"{name}.{key}"
        for name, model in models.items()
        for key, field in model["properties"].items()
        if {"number", "integer"} & {field.get("type"), *(one.get("type") for one in field.get("anyOf", ()))}
        and not field.get("description")
    ]
    assert bare == []


def test_the_header_has_the_error_in_it() -> None:
    series = points(film())
    told = header(SCENE, film(), [use()], series, SECONDS)
    expected = {
        "samples": 10, "seconds": 6, "rmse": 0.1, "relativeRmse": 0.05, "relMse": 0.01 / 4.04,
        "efficiency": 1 / 0.06, "slope": -0.5,
    }  # fmt: skip
    assert {key: float(told[key]) for key in expected} == pytest.approx(expected)
    still = header(SCENE, film(bound=0.5), [use()], [], SECONDS)
    assert still.keys() & expected.keys() == {"samples", "seconds", "rmse", "relativeRmse"}
