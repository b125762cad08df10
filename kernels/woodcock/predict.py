"""How long a scene will take on a device, and how much memory it takes: measured by a pilot of about a second."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from woodcock.batches import TILE
from woodcock.contract import PILOT as FIRST_ROUND
from woodcock.contract import STEP
from woodcock.faults import PLANES
from woodcock.film import Film, weights
from woodcock.judging import AIM
from woodcock.launch import work_items
from woodcock.layout import Layout
from woodcock.pace import RANGE_SECONDS
from woodcock.pilot import UNSEEN, Tempo, Values, joined, tempo
from woodcock.render import LARGEST_LAUNCH, Renderer
from woodcock.scene import RelativeErrorStop, SamplesStop, Scene, SecondsStop
from woodcock.space import Array

#: Seconds of rendering that a pilot takes, and the launches that they are divided into.
PILOT_SECONDS, LAUNCHES = 1.0, 5
#: Work items that keep a compute unit busy, and those of the first launch.
BUSY, FIRST = 128, 32
#: Paths of a coarse view lie further apart than the picture's: their seconds may differ by this factor more.
COARSE = 1.2
#: No more than this share of a coarse view's variance is taken for the picture's changes within its pixels.
MOST_COARSE = 0.9
#: A sample of some pixels may cost so many times as much as one of any, as far as a launch is believed.
MOST_DEARER = 8.0
#: Where less than this share of a processor's time was the pilot's, that is told.
BUSY_ELSEWHERE = 0.8
#: Films that are held while one is merged into another.
FILMS = 3


class Memory(TypedDict):
    """Bytes. device: of all buffers at once; largest: of one of them; host: of a launch, and of Films while it is
    merged."""

    device: int
    largest: int
    host: int


class Prediction(TypedDict):
    """seconds: of rendering, without reading and building, until the contract is met, in [low, high] with 95 %.

    samples: per pixel, the mean over pixels; error: estimated at the end, relative to the mean luminance. What is not
    known is None, and `says` tells why.
    """

    seconds: float | None
    low: float | None
    high: float | None
    samples: float | None
    error: float | None
    says: str


def memory(layout: Layout, width: int, height: int, channels: int, lanes: int, *, precise: bool = False) -> Memory:
    """What a layout takes on a device; channels: of the film, all of its layers; lanes, precise: of the program."""
    pixels = width * height
    rendered = work_items(pixels, lanes) * lanes
    outputs = [16 * channels * rendered, 4 * PLANES * rendered]
    lists = [4 * rendered] if layout.listed else []
    inputs = [layout.pack(precise=precise).nbytes, *(array.nbytes for array in layout.buffers.values())]
    bound = 8 * layout.channels * pixels if layout.deterministic else 0
    return {
        "device": sum([*inputs, *outputs, *lists]),
        "largest": max([*inputs, *outputs, *lists]),
        "host": sum(outputs) + FILMS * (pixels * (4 + 16 * channels) + bound),
    }


def predict(renderer: Renderer, scene: Scene) -> Prediction:
    """The rendering of a scene that is ready on a device: renders for about a second, and leaves the renderer as it is.

    Raises DeviceError.
    """
    pilot = Pilot.fly(renderer, scene.film.width, scene.film.height)
    match scene.stop:
        case SecondsStop():
            return pilot.of_seconds(scene.stop.seconds)
        case RelativeErrorStop() if pilot.values is not None:
            return pilot.of_error(pilot.values, scene.stop)
        case SamplesStop():
            return pilot.of_samples(scene.stop.samples)
    return pilot.of_samples(FIRST_ROUND)  # without noise


@dataclass(frozen=True)
class Pilot:
    """What a few launches told. values: None without noise; size: of the picture, width and height; after: the first
    sample that the view has not rendered; had: share of the processor's time that the launches had, 1 of other devices.
    """

    view: Renderer
    size: tuple[int, int]
    pace: Tempo
    values: Values | None
    after: int
    had: float

    @classmethod
    def fly(cls, renderer: Renderer, width: int, height: int) -> Pilot:
        view = _view(renderer, width, height)
        share = math.prod(view.size) / (width * height)
        films, seconds, count = list[Film](), list[float](), 1
        began, worked = time.perf_counter(), time.process_time()
        while len(films) < 4 or (len(films) < 2 + LAUNCHES and time.perf_counter() - began < PILOT_SECONDS):
            after = films[-1].ranges[-1][1] if films else 0
            start = time.perf_counter()
            films.append(view.render(after, after + count))
            seconds.append(time.perf_counter() - start)
            if len(films) == 2:
                count = min(max(int(PILOT_SECONDS / LAUNCHES / max(min(seconds), 1e-6)), 2), LARGEST_LAUNCH)
        start, worked = time.perf_counter(), time.process_time() - worked
        units = view.device.compute_units if view.device.kind == "cpu" else math.inf
        had = min(worked / (start - began) / units, 1.0) if math.isfinite(units) else 1.0
        films[-1].merge(films[-2]).rmse()
        merging = time.perf_counter() - start
        counts = np.array([film.samples for film in films], float)
        pace = tempo(counts, np.array(seconds), share, merging)
        return cls(view, (width, height), pace, _values(films[2:], share), films[-1].ranges[-1][1], had)

    @property
    def whole(self) -> bool:
        """Does the view have all of the picture's pixels?"""
        return self.view.size == self.size

    @property
    def half(self) -> float:
        """Half of the interval of 95 %, of log seconds of a sample."""
        return self.pace.half if self.whole else math.hypot(self.pace.half, math.log(COARSE))

    @property
    def below(self) -> float:
        """As `half`, if what else the processor did in the meantime is over then."""
        return math.hypot(self.half, math.log(self.had))

    def of_samples(self, samples: int) -> Prediction:
        seconds = self.pace.of(samples)
        return self._prediction(seconds, *joined(seconds, self.below, self.half), samples)

    def of_seconds(self, asked: float) -> Prediction:
        # The last ranges are as long as the pace of those before them makes them; half a sample more or less is all
        # that a device can tell; one sample is rendered in any case.
        off = math.expm1(self.below) * min(asked, RANGE_SECONDS) + self.pace.overhead
        off += self.pace.seconds * math.exp(self.half) / 2
        one = self.pace.of(1)
        least, most = joined(one, self.below, self.half)
        low, high = max(asked - off, min(asked, least) / 2), max(asked + off, most)
        return self._prediction(max(asked, one), low, high, self.pace.samples(asked))

    def of_error(self, values: Values, stop: RelativeErrorStop) -> Prediction:
        if not values.demand > 0:
            says = "The pilot saw no light, or none that varies: how many samples it takes is not known."
            return {"seconds": None, "low": None, "high": None, "samples": None, "error": None, "says": says}
        needed = values.needed(stop.relative_error)
        local, dearer, pieces = np.full((1, 1), needed[0]), 1.0, 1.0
        if stop.per == "tile":
            local = of_tiles(values, self.size) / stop.relative_error**2
            dearer = self._dearer(local)
            pieces = math.log(max(float(local.max()) / FIRST_ROUND, 1.0)) / math.log(STEP) + 1
        samples, seconds = list[float](), list[float]()
        for one in needed:
            infinite = math.isinf(one)
            count = math.inf if infinite else float(asked(local * (one / needed[0])).mean())
            work = FIRST_ROUND + (count - FIRST_ROUND) * dearer
            samples.append(count)
            seconds.append(math.inf if infinite else self.pace.of(work) + pieces * self.pace.overhead)
        less, more = (abs(math.log(end / seconds[0])) for end in seconds[1:])
        other = math.log(dearer) / 2
        low, high = joined(seconds[0], math.hypot(self.below, other, less), math.hypot(self.half, other, more))
        return self._prediction(seconds[0], low, high, samples[0])

    def _dearer(self, needed: Array) -> float:
        """How many times as much as anywhere a sample costs in the pixels that need more than the mean of all."""
        needy = np.flatnonzero(needed > max(float(needed.mean()), FIRST_ROUND)).astype(np.int32)
        if not self.view.listed or not 0 < needy.size < needed.size:
            return 1.0
        each = self.pace.seconds * math.prod(self.view.size) / math.prod(self.size)
        share = needy.size / needed.size
        count = max(2, int(PILOT_SECONDS / LAUNCHES / each / share))
        start = time.perf_counter()
        self.view.render(self.after, self.after + count, needy)
        found = (time.perf_counter() - start) / (count * each * share)
        return min(max(found, 1 / MOST_DEARER), MOST_DEARER)

    def _prediction(self, seconds: float, low: float, high: float, samples: float) -> Prediction:
        error = math.sqrt(self.values.demand / samples) if self.values and self.values.demand > 0 else None
        width, height = self.view.size
        seen = "" if self.whole else f" through {width} × {height} pixels"
        says = f"By a pilot of {self.after} samples{seen}; the interval allows for a pace up to {UNSEEN:g} times off."
        if self.had < BUSY_ELSEWHERE:
            says += f" The processor had {self.had:.0%} of its time for the pilot."
        if math.isinf(high):
            says += " The variance has a tail so heavy that no upper bound is known."
        known = None if math.isinf(high) else high
        return {"seconds": seconds, "low": low, "high": known, "samples": samples, "error": error, "says": says}


def _view(renderer: Renderer, width: int, height: int) -> Renderer:
    """The whole picture where a pilot can have enough samples of it, else as many pixels as it can, evenly spread."""
    everything = width * height
    busy = min(renderer.device.compute_units * BUSY * renderer.lanes, everything)
    pixels = float(FIRST * renderer.lanes)
    renderer.through(1, 1).render(0, 1)  # Some drivers compile once more for launches that are small.
    while True:
        scale = min(math.sqrt(pixels / everything), 1.0)
        view = renderer.through(max(round(width * scale), 1), max(round(height * scale), 1))
        start = time.perf_counter()
        view.render(0, 1)
        each = (time.perf_counter() - start) / math.prod(view.size)
        affordable = PILOT_SECONDS / (2 + 2 * LAUNCHES) / each
        if pixels >= min(affordable, everything):
            return view
        # A device that is not busy yet takes no longer for more.
        pixels = min(16 * pixels, everything if pixels < busy else min(affordable, everything))


def _values(films: Sequence[Film], share: float) -> Values | None:
    """Of launches with as many samples each; None without noise."""
    if films[0].deterministic:
        return None
    channels, samples = weights(films[0].channels), films[0].samples
    beauties = [film.layer("") for film in films]
    variance = np.stack([each.m2 @ channels for each in beauties]) / (samples - 1)
    luminance = np.stack([each.mean @ channels for each in beauties])
    coarse = 0.0
    if share < 1:
        # Within a pixel, a picture that changes evenly has a twelfth of the square of a pixel's step as variance.
        mean, all_of_it = luminance.mean(axis=0), float(variance.mean())
        steps = [float((np.diff(mean, axis=axis) ** 2).mean()) for axis in (0, 1) if mean.shape[axis] > 1]
        noise = 2 * all_of_it / (samples * len(films))
        coarse = min(sum(max(step - noise, 0.0) for step in steps) / 12, MOST_COARSE * all_of_it)
    return Values(variance, luminance, samples, share, coarse)


def of_tiles(values: Values, size: tuple[int, int]) -> Array:
    """`demand` of a tile alone, by the whole picture's mean luminance, for each pixel of the view; size: of the
    picture, width and height."""
    variance = values.variance.mean(axis=0)
    width, height = size
    columns, rows = (
        ((np.arange(seen) + 0.5) * full / seen).astype(int) // TILE
        for seen, full in zip(variance.shape[::-1], (width, height), strict=True)
    )
    tile = rows[:, None] * (columns[-1] + 1) + columns
    sums = np.bincount(tile.ravel(), variance.ravel()) / np.maximum(np.bincount(tile.ravel()), 1)
    return np.asarray(sums[tile] * (values.demand / variance.mean()))


def asked(needed: Array) -> Array:
    """Samples that a contract renders where so many are needed (contract.py): its first round, then steps."""
    more = np.maximum(needed / AIM**2 - FIRST_ROUND, 1.0)
    steps = np.ceil(np.log(more) / math.log(STEP) - 1e-9)
    return np.asarray(np.where(needed > FIRST_ROUND, FIRST_ROUND + STEP**steps, FIRST_ROUND))
