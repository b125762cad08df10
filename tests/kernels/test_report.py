"""What a report says of errors: of noise, of a bound, of a series that was cut."""

from __future__ import annotations

import json
import math
from typing import Any, cast

import numpy as np
import pytest

from woodcock.film import Film
from woodcock.layers import beauty_names
from woodcock.report import Use, build, point

COUNT = np.full((2, 3), 10, np.uint32)


def film(names: tuple[str, ...] = ("Y",), bound: float | None = None) -> Film:
    """Every channel is 2 with a variance of 0.01 of its mean."""
    mean, m2 = np.full((2, 3, len(names)), 2.0), np.full((2, 3, len(names)), 0.9)
    bounds = None if bound is None else np.full((2, 3, 1), bound)
    return Film(COUNT, mean, m2, names, ((0, 10),), bound=bounds)


def report(film: Film, norm: float | None = None, unscattered: float | None = None) -> dict[str, Any]:
    use = {
        "samples": 10, "render_seconds": 1.0, "program_hash": "a", "kinds": {}, "norm": norm, "evidence": None,
        "id": "cpu0", "name": "x", "driver": "1", "precision": "float",
        "unscattered": unscattered, "seconds": {"read": 0.0, "build": 0.0, "upload": 0.0},
    }  # fmt: skip
    built = build(film, [cast(Use, use)], [], 1.0, 1.0, 1.0)
    return cast(dict[str, Any], json.loads(json.dumps(built, allow_nan=False)))


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
    assert point(1.0, still) is None
    assert point(1.0, film()) is not None


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
