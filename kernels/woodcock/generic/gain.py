"""What leaving out gains: a scene's own program and the one with everything switched on, timed in turn."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from woodcock.generic.whole import generic_layout, is_generic, widen
from woodcock.markers import is_built
from woodcock.program import compose
from woodcock.regression import quantile
from woodcock.scene import Scene, files

if TYPE_CHECKING:
    from woodcock.render import Renderer

#: Through so many pixels a side at most, and no fewer than the second where that takes long.
SIDE, LEAST_SIDE = 128, 8

#: Pairs of launches at least; seconds of a launch and, as far as that takes no fewer pairs, of all.
PAIRS, LAUNCH, SECONDS = 5, 0.05, 0.5

#: Bytes of a scene's files at most: volumes are read once more, and held twice.
LARGEST_FILES = 64 << 20


class Gain(TypedDict):
    """lean, full: seconds per sample per pixel of the two programs; ratio: full / lean, the geometric mean over pairs
    of launches, with its 95 % interval."""

    lean: float
    full: float
    ratio: float
    low: float
    high: float


def measure_gain(lean: Renderer, scene: Scene) -> Gain | None:
    """lean: of the scene. None where the generic program is not ready on the device or does not fit the scene, where
    the scene's files are large, and for a program without random numbers, whose samples are others.

    Raises DeviceError, and what reading the scene's files raises.
    """
    from woodcock.render import Renderer, read_file  # which widens scenes itself

    width, height = (min(side, SIDE) for side in lean.size)
    ready = is_built(lean.device, compose(generic_layout(), lean.lanes), width * height)
    if lean.full or lean.deterministic or not ready:
        return None
    if sum(Path(file).stat().st_size for file in files(scene)) > LARGEST_FILES:
        return None
    layout = widen(scene, read_file)
    if not is_generic(layout):
        return None
    return compared(lean, Renderer(scene, lean.device, lanes=lean.lanes, layout=layout))


def compared(lean: Renderer, full: Renderer) -> Gain:
    """Two renderers of a scene, launched in turn. Raises DeviceError."""
    side = SIDE
    while True:
        pair = [one.through(*(min(length, side) for length in lean.size)) for one in (lean, full)]
        for one in pair:
            one.render(0, 1)
        once = [_seconds(one, 1) for one in pair]
        if max(once) <= LAUNCH or side <= LEAST_SIDE:
            break
        side //= 2
    counts = [max(1, math.ceil(LAUNCH / seconds)) for seconds in once]
    pixels = math.prod(pair[0].size)
    times: list[tuple[float, float]] = []
    began = time.perf_counter()
    while len(times) < PAIRS or time.perf_counter() - began < SECONDS:
        # Every other pair the other way round, so that a device that slows down favours neither.
        order = (0, 1) if len(times) % 2 else (1, 0)
        found = {which: _seconds(pair[which], counts[which]) / (counts[which] * pixels) for which in order}
        times.append((found[0], found[1]))
    logs = np.log(times)
    ratios = logs[:, 1] - logs[:, 0]
    middle = float(ratios.mean())
    half = quantile(0.05, len(times) - 1) * float(ratios.std(ddof=1)) / math.sqrt(len(times))
    seconds = np.exp(logs.mean(axis=0))
    return {
        "lean": float(seconds[0]),
        "full": float(seconds[1]),
        "ratio": math.exp(middle),
        "low": math.exp(middle - half),
        "high": math.exp(middle + half),
    }


def _seconds(renderer: Renderer, samples: int) -> float:
    began = time.perf_counter()
    renderer.render(0, samples)
    return time.perf_counter() - began
