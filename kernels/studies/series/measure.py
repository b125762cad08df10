"""The renders of the study, against long ones: a cube of fog, the same with its samples clamped, and a lamp in fog; and
how often the bands of short renders hold the slope."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from woodcock.convergence import EXPECTED, slope
from woodcock.device import Device
from woodcock.film import Film
from woodcock.reference import Reference
from woodcock.regression import fit, quantile
from woodcock.render import Renderer
from woodcock.scene import Scene
from woodcock.series import SERIES_GROWTH, Against, Point, Slope, against, efficiency
from woodcock.series import measure as point

#: Dense fog in daylight: paths of any length, and none that outweighs the others.
CUBE: dict[str, Any] = {
    "camera": {"kind": "perspective", "origin": [2, 1.5, -2], "target": [0.5, 0.5, 0.5], "fov": 40},
    "volumes": [
        {
            "kind": "constant",
            "shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]},
            "sigma_t": 4,
            "albedo": 0.9,
        }
    ],
    "lights": [
        {"kind": "directional", "direction": [-1, -2, 1], "irradiance": 3},
        {"kind": "constant", "radiance": 0.2},
    ],
}
#: A spot light inside a room of fog, above a floor.
LAMP: dict[str, Any] = {
    "camera": {"kind": "perspective", "origin": [0, 1.5, 9], "target": [0, 1.8, 0], "fov": 38},
    "volumes": [
        {
            "kind": "constant",
            "shape": {"kind": "box", "min": [-8, 0, -8], "max": [8, 6, 8]},
            "sigma_t": 0.07,
            "albedo": 0.8,
            "phase": {"kind": "henyey_greenstein", "g": 0.6},
        }
    ],
    "surfaces": [
        {
            "kind": "rectangle",
            "to_world": [[8, 0, 0, 0], [0, 0, 8, 0], [0, -8, 0, 0], [0, 0, 0, 1]],
            "material": {"kind": "diffuse", "reflectance": 0.2},
        }
    ],
    "lights": [
        {
            "kind": "spot",
            "position": [-3.2, 4.6, -1.5],
            "target": [0.6, 0.9, 0.2],
            "intensity": 400,
            "cutoff": 17,
            "beam": 13,
        },
        {"kind": "constant", "radiance": 0.016},
    ],
}


@dataclass(frozen=True)
class Effort:
    """samples, reference: of the render and of what it is held against, in pictures of width × height; clamp: in units
    of the mean luminance. runs: renders of band × band pixels and band_samples.
    """

    width: int = 192
    height: int = 144
    samples: int = 2048
    reference: int = 16384
    clamp: float = 1.5
    runs: int = 200
    band: int = 16
    band_samples: int = 210


class Run(NamedTuple):
    """A render. mean, noise: mean luminance of its reference, and √⟨variance⟩ of that; worth: efficiency at every
    point, by the device's seconds."""

    mean: float
    noise: float
    series: list[Point]
    slope: Slope
    against: Against
    worth: list[float]


class Coverage(NamedTuple):
    """Shares of runs whose 95 % band holds -1/2: of the estimated and of the true error, and of an ordinary line
    through the same points; flagged: runs that were."""

    points: int
    estimated: float
    true: float
    ordinary: float
    flagged: int


@dataclass(frozen=True)
class Numbers:
    effort: Effort
    device: str
    plain: Run
    clamped: Run
    lamp: Run
    coverage: list[Coverage]


def scene(described: dict[str, Any], width: int, height: int, seed: int) -> Scene:
    return Scene.model_validate({**described, "film": {"width": width, "height": height}, "seed": seed})


def measure(device: Device, effort: Effort) -> Numbers:
    def ready(described: dict[str, Any], seed: int) -> Renderer:
        return Renderer(scene(described, effort.width, effort.height, seed), device)

    long, room = (ready(described, 1).render(0, effort.reference) for described in (CUBE, LAMP))
    renderer, most = ready(CUBE, 2), effort.clamp * long.mean_luminance()
    return Numbers(
        effort,
        device.platform,
        run(renderer.render, effort.samples, long),
        run(lambda start, stop: clamped(renderer, start, stop, most), effort.samples, long),
        run(ready(LAMP, 2).render, effort.samples, room),
        coverage(device, effort),
    )


def counts(last: int) -> list[int]:
    """Samples at the points of a series, from 2 on."""
    found = [2]
    while found[-1] < last:
        found.append(min(last, math.ceil(found[-1] * SERIES_GROWTH)))
    return found


def run(render: Callable[[int, int], Film], samples: int, long: Film) -> Run:
    truth = Reference(long.mean, long.variance(), "long")
    film, series, worth, seconds = render(0, 1), list[Point](), list[float](), 0.0
    for n in counts(samples):
        began = time.perf_counter()
        film = film.merge(render(film.samples, n))
        seconds += time.perf_counter() - began
        found, worthy = point(film, seconds, seconds, truth), efficiency(film, seconds)
        assert found is not None
        assert worthy is not None
        series.append(found)
        worth.append(worthy)
    return Run(long.mean_luminance(), long.rmse(), series, slope(series), against(film, truth), worth)


def clamped(renderer: Renderer, start: int, stop: int, most: float) -> Film:
    """Samples that are brighter than `most` count as that: what a firefly filter does. One launch a sample."""
    film: Film | None = None
    for sample in range(start, stop):
        one = renderer.render(sample, sample + 1)
        one = replace(one, mean=np.minimum(one.mean, most))
        film = one if film is None else film.merge(one)
    assert film is not None
    return film


def coverage(device: Device, effort: Effort) -> list[Coverage]:
    """Of renders that share no sample. The clock is their samples: how evenly a device works is no part of it."""
    renderer, each = Renderer(scene(CUBE, effort.band, effort.band, 3), device), effort.band_samples
    long = renderer.render(effort.runs * each, (effort.runs + 64) * each)
    truth, runs = Reference(long.mean, long.variance(), "long"), []
    for first in range(0, effort.runs * each, each):
        film, series = renderer.render(first, first + 1), list[Point]()
        for n in counts(each):
            film = film.merge(renderer.render(first + film.samples, first + n))
            found = point(film, 0.0, n, truth)
            assert found is not None
            series.append(found)
        runs.append(series)
    return [_coverage([series[:points] for series in runs]) for points in (4, 8, len(counts(each)))]


def _coverage(runs: list[list[Point]]) -> Coverage:
    hits, flagged = np.zeros(3), 0
    for series in runs:
        said, x = slope(series), np.log([one["samples"] for one in series])
        line = fit(x, np.log([one["rmse"] for one in series]), np.eye(len(x)))
        true = said["against"]
        assert said["low"] is not None
        assert said["high"] is not None
        assert true is not None
        hits += (
            said["low"] <= EXPECTED <= said["high"],
            true["low"] <= EXPECTED <= true["high"],
            abs(line.slope - EXPECTED) <= quantile(0.05, line.freedom) * line.error,
        )
        flagged += said["verdict"] == "flagged"
    return Coverage(len(runs[0]), *(hits / len(runs)).tolist(), flagged)
