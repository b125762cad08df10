"""What float32 does to a picture: some of its paths once more in double precision, by the same random numbers.

Both take the same decisions but where rounding turns one, so that their difference shows rounding almost without noise.
"""

from __future__ import annotations

import math
import time
from typing import TypedDict

import numpy as np

from woodcock.launch import Launcher, statistics
from woodcock.layout import Layout
from woodcock.program import compose
from woodcock.space import Array

#: The picture is looked at through so many pixels a side, as far as it has them.
SIDE = 32

#: Samples of a pixel at most, and what their paths may cost in double precision, seconds.
MOST_SAMPLES, MOST_SECONDS = 16, 2.0

#: Doubles, one lane at a time, cost about as many times as much as floats.
DEARER = 20.0


class Drift(TypedDict):
    """relative: (float32 - float64) / float64 of the mean over pixels and channels, ± error, its standard error;
    largest: of a pixel, relative to the mean; turned: share of the pixels in which a decision turned; paths: compared.
    """

    relative: float
    error: float
    largest: float
    turned: float
    paths: int


def drift(layout: Layout, launcher: Launcher) -> Drift | None:
    """Of a layout by random paths, on a device that has doubles; None where the compared paths carry no light.

    launcher: of its program in floats; its inputs are used again. Raises DeviceError.
    """
    small, (width, height) = _small(layout)
    pixels, channels = width * height, sum("." not in name for name in layout.names)
    single = launcher.with_inputs({"scene": small.pack()})
    began = time.perf_counter()
    single.run(pixels, 0, 1)
    seconds = max(time.perf_counter() - began, 1e-4)
    samples = int(min(max(MOST_SECONDS / (DEARER * seconds), 1), MOST_SAMPLES))

    twin = Launcher(launcher.context, compose(layout, 1, precise=True), len(layout.names), launcher.inputs)
    twin.upload({"scene": small.pack(precise=True)})
    ours, doubles = (statistics(each.run(pixels, 0, samples)[0], samples)[0][:, :channels] for each in (single, twin))
    return compared(ours, doubles, pixels * samples)


def compared(single: Array, double: Array, paths: int) -> Drift | None:
    """Of two pictures (pixels, channels) by so many paths."""
    mean = float(double.mean())
    if not mean > 0:
        return None
    # A pixel's channels share their paths.
    off = (single - double).mean(axis=1) / mean
    scale = np.maximum(np.abs(double), mean)
    return {
        "relative": float(off.mean()),
        "error": float(off.std(ddof=1) / math.sqrt(off.size)) if off.size > 1 else 0.0,
        "largest": float(np.abs(off).max()),
        # Paths that took the same decisions differ by the rounding of their weights alone.
        "turned": float((np.abs(single - double) > 1e-4 * scale).any(axis=1).mean()),
        "paths": paths,
    }


def _small(layout: Layout) -> tuple[Layout, tuple[int, int]]:
    """The same view through few pixels, and how many; its program is the same."""
    (film,) = (record for record in layout.records if record.member == "film")
    width, height = (min(film.values[side], SIDE) for side in ("width", "height"))
    return layout.through(width, height), (width, height)
