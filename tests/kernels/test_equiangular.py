"""Equiangular sampling against the textbook's formulas in float64, where those hold, and against itself everywhere."""

from __future__ import annotations

import numpy as np
import pytest
from tests.kernels.device_code import needs

from woodcock.device import Context
from woodcock.evaluate import evaluate

N = 4096
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


def run(context: Context, lanes: int, case: tuple[float, ...], expression: str, x: np.ndarray) -> np.ndarray:
    along, off, near, far = case
    origin = np.array([0.1, 0.2, -0.3])
    light = origin + along * DIRECTION + off * SIDE
    vectors = {"o": origin, "d": DIRECTION, "l": light}
    inputs = {
        f"{name}{axis}": np.full(x.size, v[i], np.float32)
        for name, v in vectors.items()
        for i, axis in enumerate("xyz")
    }
    inputs |= {"near": np.full(x.size, near, np.float32), "far": np.full(x.size, far, np.float32), "x": x}
    body = "vector o = vector_of(ox, oy, oz), d = vector_of(dx, dy, dz), l = vector_of(lx, ly, lz);"
    (got,) = evaluate(
        context,
        [expression.format("o, d, l, near, far")],
        inputs,
        lanes=lanes,
        parts=[*needs(1), "core/equiangular.h"],
        body=body,
    )
    return got.astype(float)


def angles(case: tuple[float, ...]) -> tuple[float, float]:
    along, off, near, far = case
    return float(np.arctan((near - along) / off)), float(np.arctan((far - along) / off))


@pytest.mark.parametrize("name", [name for name in CASES if name not in OTHERS])
def test_textbook(context: Context, lanes: int, name: str) -> None:
    case = CASES[name]
    along, off, near, far = case
    u = ((np.arange(N) + 0.5) / N).astype(np.float32)
    t = run(context, lanes, case, "equiangular_sample({}, x)", u)
    assert ((t >= np.float32(near)) & (t <= np.float32(far))).all()
    first, last = angles(case)
    right = along + off * np.tan(first + (last - first) * u.astype(float))
    expected = off / ((last - first) * (off**2 + (right - along) ** 2))
    # An error of a distance counts by the probability it holds; none can be less than distances are rounded by.
    assert (np.abs(t - right) < 1e-5 / expected + 1.2e-7 * np.abs(right)).all()

    places = np.clip(right.astype(np.float32), np.float32(near), np.float32(far))
    pdf = run(context, lanes, case, "equiangular_pdf({}, x)", places)
    assert np.allclose(pdf, expected, rtol=1e-4)


@pytest.mark.parametrize("name", CASES)
def test_density_is_that_of_the_samples(context: Context, lanes: int, name: str) -> None:
    """The integral of the density up to a sample is its uniform; nothing outside the segment has a density."""
    case = CASES[name]
    along, _, near, far = case
    u = ((np.arange(N) + 0.5) / N).astype(np.float32)
    t = run(context, lanes, case, "equiangular_sample({}, x)", u)
    assert (np.diff(t) >= 0).all()

    # Places crowd around the light where the segment passes it or has no end.
    places = np.linspace(near, far, 4 * N)
    if near <= along <= far or far > 100:
        ends = np.arcsinh((np.array([near, far]) - along) / 1e-6)
        places = along + 1e-6 * np.sinh(np.linspace(*ends, 4 * N))
    places = np.clip(places.astype(np.float32), np.float32(near), np.float32(far))
    pdf = run(context, lanes, case, "equiangular_pdf({}, x)", places)
    assert np.isfinite(pdf).all()
    assert (pdf >= 0).all()
    steps = np.diff(places.astype(float)) * (pdf[1:] + pdf[:-1]) / 2
    cumulative = np.concatenate([[0], np.cumsum(steps)])
    assert cumulative[-1] == pytest.approx(1, abs=2e-3)
    assert np.allclose(np.interp(t, places.astype(float), cumulative), u, rtol=0, atol=2e-3)

    beyond = np.array([near - 0.05, near - 1, 2 * far + 1], np.float32)
    assert (run(context, lanes, case, "equiangular_pdf({}, x)", beyond) == 0).all()


def test_it_follows_the_light(context: Context) -> None:
    """Sampled so, 1 / distance² has no variance."""
    along, off, _, _ = CASES["beside"]
    u = np.random.default_rng(8).random(N, dtype=np.float32)
    t = run(context, 1, CASES["beside"], "equiangular_sample({}, x)", u)
    pdf = run(context, 1, CASES["beside"], "equiangular_pdf({}, x)", t.astype(np.float32))
    weight = 1 / (off**2 + (t - along) ** 2) / pdf
    first, last = angles(CASES["beside"])
    assert np.allclose(weight, (last - first) / off, rtol=1e-4)
