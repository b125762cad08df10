"""Equiangular sampling against the textbook's formulas in float64, where those hold, and against itself everywhere."""

from __future__ import annotations

import numpy as np
import pytest
from tests.kernels.device_code import needs

from woodcock.device import Context
from woodcock.evaluate import evaluate

U = ((np.arange(4096) + 0.5) / 4096).astype(np.float32)
#: Where the light lies as seen from the ray's origin, along the ray and off it, and the segment, from near to far.
CASES = {
    "ahead": (0.7, 0.2, 0.1, 0.6),
    "beside": (0.4, 0.05, 0.1, 1.2),
    "behind": (-0.3, 0.3, 0.0, 0.9),
    "grazing": (0.4, 0.002, 0.1, 1.2),
    "at the near end": (0.1, 0.01, 0.1, 1.0),
    "far away": (1e4, 3e4, 0.1, 1.0),
    "far ahead": (3e3, 1.0, 0.1, 1.0),
    "tiny segment": (0.4, 0.2, 0.0, 1e-6),
    "vanishing segment": (0.4, 0.2, 0.0, 1e-20),
    "endless": (0.4, 0.2, 0.1, 1e30),
    "endless, behind": (-0.4, 0.2, 0.1, 1e30),
    "on the ray": (0.4, 0.0, 0.1, 1.2),
    "on the ray, ahead": (2.0, 0.0, 0.1, 1.2),
    "on the ray, behind": (-1.0, 0.0, 0.1, 1.2),
    "on the ray, endless": (0.4, 0.0, 0.1, 1e30),
    "on the ray's near end": (0.1, 0.0, 0.1, 1.2),
}
#: Where the density leaves the textbook's on purpose, as a light on the ray would draw all samples to itself, and where
#: float64 does not resolve the textbook's angles.
OTHERS = [name for name in CASES if name.startswith(("on the ray", "vanishing"))]

DIRECTION = np.array([0.36, -0.48, 0.8])
SIDE = np.array([0.8, 0.6, 0.0])


Values = dict[str, np.ndarray]


def run(context: Context, lanes: int, expression: str, values: Values) -> Values:
    """An expression of x and e over the values of every case, all cases in one kernel."""
    size = len(next(iter(values.values())))
    along, off, near, far = (np.repeat([CASES[name][i] for name in values], size) for i in range(4))
    origin = np.array([0.1, 0.2, -0.3])
    light = origin + along[:, None] * DIRECTION + off[:, None] * SIDE
    vectors = {"o": np.broadcast_to(origin, light.shape), "d": np.broadcast_to(DIRECTION, light.shape), "l": light}
    inputs = {f"{name}{axis}": v[:, i] for name, v in vectors.items() for i, axis in enumerate("xyz")}
    inputs |= {"near": near, "far": far, "x": np.concatenate(list(values.values()))}
    (got,) = evaluate(
        context,
        [expression],
        {name: np.ascontiguousarray(array, np.float32) for name, array in inputs.items()},
        lanes=lanes,
        parts=[*needs(1), "core/equiangular.h"],
        body="vector o = vector_of(ox, oy, oz), d = vector_of(dx, dy, dz), l = vector_of(lx, ly, lz);"
        "equiangular e = equiangular_of(o, d, l, near, far);",
    )
    return dict(zip(values, got.astype(float).reshape(-1, size), strict=True))


def samples(context: Context, lanes: int) -> Values:
    """Distances of the uniforms U, by case."""
    return run(context, lanes, "equiangular_sample(&e, x)", dict.fromkeys(CASES, U))


def within(case: tuple[float, ...], t: np.ndarray) -> np.ndarray:
    """Distances as float32 has them, kept in the segment."""
    return np.clip(t.astype(np.float32), np.float32(case[2]), np.float32(case[3]))


def angles(case: tuple[float, ...]) -> tuple[float, float]:
    along, off, near, far = case
    return float(np.arctan((near - along) / off)), float(np.arctan((far - along) / off))


def test_textbook(context: Context, lanes: int) -> None:
    sampled, right, expected = samples(context, lanes), {}, {}
    for name in CASES.keys() - OTHERS:
        along, off, near, far = CASES[name]
        first, last = angles(CASES[name])
        right[name] = along + off * np.tan(first + (last - first) * U.astype(float))
        expected[name] = off / ((last - first) * (off**2 + (right[name] - along) ** 2))
        t = sampled[name]
        assert ((t >= np.float32(near)) & (t <= np.float32(far))).all(), name
        # An error of a distance counts by the probability it holds; none can be less than distances are rounded by.
        assert (np.abs(t - right[name]) < 1e-5 / expected[name] + 1.2e-7 * np.abs(right[name])).all(), name
    places = {name: within(CASES[name], right[name]) for name in right}
    for name, pdf in run(context, lanes, "equiangular_pdf(&e, x)", places).items():
        assert np.allclose(pdf, expected[name], rtol=1e-4), name


def test_density_is_that_of_the_samples(context: Context, lanes: int) -> None:
    """The integral of the density up to a sample is its uniform; nothing outside the segment has a density."""
    places, beyond = {}, {}
    for name, (along, _, near, far) in CASES.items():
        # Places crowd around the light where the segment passes it or has no end.
        places[name] = np.linspace(near, far, 4 * U.size)
        if near <= along <= far or far > 100:
            ends = np.arcsinh((np.array([near, far]) - along) / 1e-6)
            places[name] = along + 1e-6 * np.sinh(np.linspace(*ends, 4 * U.size))
        places[name] = within(CASES[name], places[name])
        beyond[name] = np.array([near - 0.05, near - 1, 2 * far + 1])
    sampled, density = samples(context, lanes), run(context, lanes, "equiangular_pdf(&e, x)", places)
    for name, pdf in density.items():
        assert (np.diff(sampled[name]) >= 0).all(), name
        assert np.isfinite(pdf).all(), name
        assert (pdf >= 0).all(), name
        x = places[name].astype(float)
        cumulative = np.concatenate([[0], np.cumsum(np.diff(x) * (pdf[1:] + pdf[:-1]) / 2)])
        assert cumulative[-1] == pytest.approx(1, abs=2e-3), name
        assert np.allclose(np.interp(sampled[name], x, cumulative), U, rtol=0, atol=2e-3), name
    for name, outside in run(context, lanes, "equiangular_pdf(&e, x)", beyond).items():
        assert (outside == 0).all(), name


def test_it_follows_the_light(context: Context) -> None:
    """Sampled so, 1 / distance² has no variance."""
    along, off, _, _ = CASES["beside"]
    t = samples(context, 1)["beside"]
    pdf = run(context, 1, "equiangular_pdf(&e, x)", {"beside": t})["beside"]
    weight = 1 / (off**2 + (t - along) ** 2) / pdf
    first, last = angles(CASES["beside"])
    assert np.allclose(weight, (last - first) / off, rtol=1e-4)
