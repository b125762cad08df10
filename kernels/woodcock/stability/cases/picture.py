"""The longest pictures, the last samples, the largest seeds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from woodcock.render import LARGEST_LAUNCH
from woodcock.stability import exact
from woodcock.stability.case import Case, Description, by_hits, exactly
from woodcock.stability.scenes import LOOPS, Kind, block, grid, noise, parallel, seen

GROUP = "pictures and samples"
LONGEST = 1 << 16
LAST = 1 << 31
VALUES = noise(3, 5, 4)


def _long(width: int, height: int, keys: Kind, folder: Path) -> Description:
    """The camera sees as much of a long block as the picture is long."""
    x, y = width / min(width, height), height / min(width, height)
    medium = block(1.0, 0, (0, 0, 0), (x, y, 1.0))
    camera = parallel((x / 2, y / 2, -1), (x / 2, y / 2, 0), y)
    return seen(medium, camera=camera, film={"width": width, "height": height}) | keys


def _uneven(keys: Kind, folder: Path) -> Description:
    return seen(grid(folder, VALUES, 0.0, scale=2.0)) | keys


def _mean() -> float:
    return exact.through_columns_mean(2.0 * VALUES.astype(float))


def _cases() -> Iterator[Case]:
    through = partial(math.exp, -1)
    for width, height in ((1, 1), (LONGEST, 1), (1, LONGEST), (LONGEST, 4), (3, 7)):
        name = f"{width} × {height} pixels"
        yield exactly(GROUP, name, partial(_long, width, height, {}), through)
        for loop, keys in LOOPS.items():
            samples = (0, 4) if width * height > 100 else (0, 4096)
            yield by_hits(GROUP, f"{name}, {loop}", partial(_long, width, height, keys), through, samples)
    ranges = {
        "the last samples": (LAST - 256, LAST),
        "samples beyond a launch's most": (LARGEST_LAUNCH - 8, LARGEST_LAUNCH + 248),
        "as many as a launch takes, and one": (0, LARGEST_LAUNCH + 1),
    }
    for name, samples in ranges.items():
        for loop, keys in LOOPS.items():
            film = {"film": {"width": 2, "height": 2}} if samples[0] == 0 else {}
            yield by_hits(GROUP, f"{name}, {loop}", partial(_uneven, keys | film), _mean, samples)
    for seed in (0, 2**32 - 1):
        for loop, keys in LOOPS.items():
            scene = partial(_uneven, keys | {"seed": seed})
            yield by_hits(GROUP, f"seed {seed}, {loop}", scene, _mean, (0, 256))


CASES = tuple(_cases())
