"""Predictions: that the intervals hold, on streams of known laws and on the demonstration's scenes."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock import predict as predicting
from woodcock.batches import TILE
from woodcock.contract import next_round
from woodcock.device import Context, Device
from woodcock.drive import drive
from woodcock.film import Film
from woodcock.layout import Layout
from woodcock.pilot import Tempo, Values, joined, tempo
from woodcock.plan import lay_out
from woodcock.predict import asked, memory, of_tiles, predict
from woodcock.render import Renderer, read_file
from woodcock.scene import RelativeErrorStop, Scene, load

from ..conftest import described

EXAMPLES = Path(__file__).parents[2] / "client" / "woodcock_client" / "examples"
DATA = Path(__file__).resolve().parents[2].parent / "shared" / "data"

Draw = Callable[[np.random.Generator, tuple[int, ...]], Any]

#: Streams of samples: those whose squares have a mean that is soon known, and those whose have not.
LIGHT: dict[str, Draw] = {
    "exponential": lambda rng, shape: rng.exponential(1, shape),
    "narrow": lambda rng, shape: 1 + 0.3 * rng.standard_normal(shape),
    "one in ten": lambda rng, shape: (rng.random(shape) < 0.1).astype(float),
    "lognormal": lambda rng, shape: rng.lognormal(0, 1, shape),
}
HEAVY: dict[str, Draw] = {
    "one in a thousand": lambda rng, shape: (rng.random(shape) < 1e-3).astype(float),
    "Pareto, infinite fourth moment": lambda rng, shape: 1 + rng.pareto(2.5, shape),
    "Pareto, infinite variance": lambda rng, shape: 1 + rng.pareto(1.7, shape),
    "wide lognormal": lambda rng, shape: rng.lognormal(0, 2, shape),
}
CASES = 60


def coverage(draw: Draw, rng: np.random.Generator) -> float:
    """How often the samples that a render of 32 × 64 pixels stops at lie in what five launches of two predict."""
    height, width, launches, each, most = 32, 64, 5, 2, 128
    # Brightness changes from place to place, by a factor of 20.
    place = np.exp(1.5 * np.sin(np.arange(height) / 9)[:, None] * np.cos(np.arange(width) / 11))
    numbers, first = np.arange(1, most + 1), launches * each
    runs = []
    for _ in range(CASES):
        values = draw(rng, (most, height, width)) * place
        pilot = values[: launches * each].reshape(launches, each, height, width)
        flat = values.reshape(most, -1)
        mean = np.cumsum(flat, axis=0) / numbers[:, None]
        m2 = np.cumsum(flat**2, axis=0) - numbers[:, None] * mean**2
        n = numbers[first - 1 :]
        error = np.sqrt(m2[first - 1 :].mean(axis=1) / (n - 1) / n) / mean[first - 1 :].mean(axis=1)
        runs.append((Values(pilot.var(axis=1, ddof=1), pilot.mean(axis=1), each), error))
    goal = float(np.median([error[50] for _, error in runs]))
    hits = 0
    for values, error in runs:
        _, low, high = values.needed(goal)
        met = np.flatnonzero(error <= goal)
        stop = int(met[0]) + first if met.size else most
        # Where the render goes on beyond what was simulated, only that the interval reaches so far can be seen.
        hits += bool((not met.size or low <= stop + 1) and high >= stop - 1)
    return hits / CASES


@pytest.mark.parametrize("name", LIGHT)
def test_intervals_hold(name: str, rng: Callable[[int], np.random.Generator]) -> None:
    assert coverage(LIGHT[name], rng(1)) >= 0.95


@pytest.mark.parametrize("name", HEAVY)
def test_intervals_hold_for_heavy_tails(name: str, rng: Callable[[int], np.random.Generator]) -> None:
    """Without the tail that the pilot has not seen, it would be about 0.8."""
    assert coverage(HEAVY[name], rng(2)) >= 0.9


def values(rng: np.random.Generator, sigma: Any, launches: int = 5, each: int = 8, **more: Any) -> Values:
    """Normal samples of mean 2 and this deviation in each of 64 × 64 pixels."""
    samples = 2 + sigma * rng.standard_normal((launches, each, 64, 64))
    return Values(samples.var(axis=1, ddof=1), samples.mean(axis=1), each, **more)


def test_samples_are_by_the_variance_over_the_square_of_the_error(rng: Callable[[int], np.random.Generator]) -> None:
    found = values(rng(3), 1.0)
    middle, low, high = found.needed(0.05)
    assert middle == pytest.approx(0.25 / 0.05**2, rel=0.03)
    assert low < 100 < high
    assert high / low < 1.2, "a known variance is known"
    wide = values(rng(3), 1.0, launches=2, each=2)
    assert wide.interval(100)[1] / wide.interval(100)[0] > high / low


def test_what_a_coarse_view_adds_is_taken_off(rng: Callable[[int], np.random.Generator]) -> None:
    fine = values(rng(4), 1.0)
    coarse = Values(fine.variance + 0.5, fine.luminance, fine.samples, 0.1, 0.5)
    assert coarse.demand == pytest.approx(fine.demand)
    low, high = coarse.interval(100)
    assert low < fine.demand < high
    assert high / low > 2, "the correction itself is not known well"


def test_nothing_is_predicted_of_the_dark() -> None:
    dark = Values(np.zeros((3, 4, 4)), np.zeros((3, 4, 4)), 2)
    assert math.isnan(dark.demand)
    assert dark.interval(10) == (0.0, math.inf)


# Contracts


@pytest.mark.parametrize("error", [0.01, 0.05, 0.1, 0.3])
def test_rounds_are_those_of_the_contract(error: float, rng: Callable[[int], np.random.Generator]) -> None:
    """The rule of contract.py, played to its end on films whose variance is known."""
    stop = RelativeErrorStop(relative_error=error)
    film: Film | None = None
    for _ in range(20):
        if not (pieces := next_round(stop, film)):
            break
        samples = pieces[-1].stop
        squares = rng(5).chisquare(samples - 1, (64, 64, 1))  # of normal samples with variance 1 and mean 2
        film = Film(np.full((64, 64), samples, np.uint32), np.full((64, 64, 1), 2.0), squares, ("Y",), ((0, samples),))
    assert film is not None
    assert film.samples == pytest.approx(float(asked(np.array(0.25 / error**2))), rel=0.2)


def test_tiles_need_what_they_vary(rng: Callable[[int], np.random.Generator]) -> None:
    sigma = np.ones((64, 64))
    sigma[:TILE, TILE:] = 4
    for share, size in ((1.0, (64, 64)), (0.25, (128, 128))):
        found = of_tiles(values(rng(6), sigma, share=share), size)
        assert found.shape == (64, 64)
        quiet, loud = found[-1, 0], found[0, -1]
        assert (loud, quiet) == (pytest.approx(16 / 4, rel=0.1), pytest.approx(1 / 4, rel=0.1))
        assert found.mean() == pytest.approx(values(rng(6), sigma).demand)
    assert len(np.unique(found)) == 16, "the picture has 4 × 4 tiles"


# Pace


def test_overhead_is_told_from_samples() -> None:
    counts = np.array([1, 1, 10, 10, 10.0])
    found = tempo(counts, 0.02 + 0.01 * counts, 0.5, 0.003)
    assert (found.seconds, found.overhead) == (pytest.approx(0.02), pytest.approx(2 * 0.023))
    assert found.spread == pytest.approx(0, abs=1e-6)
    assert found.half == pytest.approx(math.log(2.0)), "load that a pilot cannot see"
    uneven = tempo(counts, np.array([0.03, 0.03, 0.1, 0.12, 0.14]), 1.0, 0.0)
    assert uneven.half > found.half


def test_seconds_count_ranges() -> None:
    pace = Tempo(0.01, 0.1, 0.0)
    assert pace.of(1000) - pace.of(500) == pytest.approx(500 * 0.01 + 5 * 0.1)
    assert pace.samples(11) == pytest.approx(1000)


def test_an_interval_may_have_no_upper_end() -> None:
    assert joined(2.0, math.log(2), math.log(3)) == (pytest.approx(1), pytest.approx(6))
    assert joined(2.0, 0.0, math.inf) == (2.0, math.inf)


# On the device


@pytest.mark.parametrize("kind", ["random", "deterministic", "tiles"])
def test_memory_is_what_is_allocated(kind: str, box: dict[str, Any], device: Device, grid: Any) -> None:
    box["volumes"].append(grid(np.linspace(0, 1, 4096).reshape(16, 16, 16), scale=2))
    box["film"] = {"width": 50, "height": 30}
    if kind == "deterministic":
        del box["integrator"]
        box["volumes"] = [{**volume, "albedo": 0} for volume in box["volumes"]]
    if kind == "tiles":
        box["stop"] = {"kind": "relative_error", "relative_error": 0.1, "per": "tile"}
    scene = described(box)
    buffers: list[Any] = []
    with pytest.MonkeyPatch.context() as patch:
        for name in ("upload", "output"):
            patch.setattr(Context, name, _noting(getattr(Context, name), buffers))
        renderer = Renderer(scene, device)
        inputs = len(renderer._launcher.inputs)
        held = buffers[:inputs]
        buffers.clear()
        film = renderer.render(0, 2)
    precise = renderer._precision == "double"
    # The layout with its volumes: the renderer has let go of them.
    layout: Layout = lay_out(scene, read_file)
    found = memory(layout, 50, 30, len(renderer.names), renderer.lanes, precise=precise)
    assert found["device"] == sum(buffer.size for buffer in [*held, *buffers])
    assert found["largest"] == max(buffer.size for buffer in [*held, *buffers])
    arrays = [film.count, film.mean, film.m2, *([] if film.bound is None else [film.bound])]
    outputs = sorted((buffer.size for buffer in buffers), reverse=True)[:2]
    assert found["host"] == predicting.FILMS * sum(array.nbytes for array in arrays) + sum(outputs)


def _noting(function: Callable[..., Any], buffers: list[Any]) -> Callable[..., Any]:
    def call(self: Context, array: Any) -> Any:
        buffers.append(function(self, array))
        return buffers[-1]

    return call


def test_a_pilot_leaves_the_renderer_as_it_is(box: dict[str, Any], device: Device, grid: Any) -> None:
    """Also where it finds densities above the majorant, which a renderer repairs for good."""
    box["volumes"] = [grid(np.random.default_rng(7).random((8, 8, 8)), scale=9)]
    box["film"] = {"width": 400, "height": 300}
    scene = described(box)
    renderer, other = Renderer(scene, device), Renderer(scene, device)
    held, layout = dict(renderer._launcher.inputs), renderer._layout
    told = predict(renderer, scene)
    assert told["samples"] == 64
    assert dict(renderer._launcher.inputs) == held
    assert renderer._layout is layout
    assert np.array_equal(renderer.render(0, 2).mean, other.render(0, 2).mean)


def test_a_pilot_is_short(box: dict[str, Any], device: Device) -> None:
    """And sees all of a picture through fewer pixels where a sample of it takes seconds."""
    box["volumes"][0] |= {"sigma_t": 60, "albedo": 0.999}
    box["film"] = {"width": 1200, "height": 800}
    box["stop"] = {"kind": "relative_error", "relative_error": 0.1}
    scene = described(box)
    renderer = Renderer(scene, device)
    began = time.process_time()
    told = predict(renderer, scene)
    assert time.process_time() - began < 10 * predicting.PILOT_SECONDS * device.compute_units
    assert "through" in told["says"]
    # As a small picture of the same view has it.
    small = Renderer(described(box | {"film": {"width": 48, "height": 32}}), device).render(0, 64)
    found = (small.rmse() / small.mean_luminance()) ** 2 * 64
    assert told["error"] is not None
    assert told["samples"] is not None
    assert told["error"] ** 2 * told["samples"] == pytest.approx(found, rel=0.3)


def test_a_dark_scene_has_no_prediction(box: dict[str, Any], device: Device) -> None:
    box["lights"] = []
    box["stop"] = {"kind": "relative_error", "relative_error": 0.1}
    scene = described(box)
    told = predict(Renderer(scene, device), scene)
    assert (told["seconds"], told["low"], told["high"], told["samples"], told["error"]) == (None,) * 5
    assert told["says"].startswith("The pilot saw no light")


# The demonstration


def scenes() -> list[Path]:
    return [*sorted(EXAMPLES.glob("*.json")), *sorted((EXAMPLES / "data").glob("*.json"))]


def small(path: Path, folder: Path, stop: dict[str, Any]) -> Scene:
    """An example with a small film; skips where its files are not there."""
    scene = json.loads(path.read_text())
    scene |= {"film": {"width": 192, "height": 144}, "stop": stop}

    def found(part: Any) -> None:
        if isinstance(part, dict):
            if isinstance(file := part.get("file"), str):
                there = [base / file for base in (path.parent, DATA) if (base / file).is_file()]
                if not there:
                    pytest.skip(f"{file} is not there")
                part["file"] = str(there[0])
            part = list(part.values())
        if isinstance(part, list):
            for each in part:
                found(each)

    found(scene)
    (folder / path.name).write_text(json.dumps(scene))
    return load(folder / path.name)


@pytest.mark.benchmark
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("kind", ["samples", "seconds", "image", "tile"])
@pytest.mark.parametrize("path", scenes(), ids=lambda path: path.stem)
def test_renders_end_when_they_were_predicted_to(path: Path, kind: str, tmp_path: Path, device: Device) -> None:
    """Contracts are sized to some four seconds, by a prediction of another one."""
    first = small(path, tmp_path, {"kind": "seconds", "seconds": 4})
    told = predict(Renderer(first, device), first)
    samples, error = told["samples"], told["error"]
    assert samples is not None
    stops: dict[str, dict[str, Any]] = {
        "samples": {"kind": "samples", "samples": max(int(samples), 1)},
        "seconds": {"kind": "seconds", "seconds": 4},
        "image": {"kind": "relative_error", "relative_error": min(error or 0.1, 1.0)},
        "tile": {"kind": "relative_error", "relative_error": min(error or 0.1, 1.0), "per": "tile"},
    }
    scene = small(path, tmp_path, stops[kind])
    renderer = Renderer(scene, device)
    told = predict(renderer, scene)
    began = time.perf_counter()
    film, _, _ = drive(renderer, scene, lambda *_: None)
    took = time.perf_counter() - began
    print(f"\n{path.stem}, {kind}: {took:.2f} s, {film.mean_samples:.1f} samples; {told}")
    assert told["low"] is not None
    assert told["low"] <= took <= (told["high"] or math.inf)
