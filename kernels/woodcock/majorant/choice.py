"""The majorant of a scene that names none: the one by which its paths take fewer steps."""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter

import numpy as np

from woodcock.formats import Grid
from woodcock.layout import Read
from woodcock.majorant.grid import Bounded, bounds, counts, mean_chord
from woodcock.majorant.hops import crossing, hops, pace
from woodcock.scene import GlobalMajorant, GridMajorant, GridVolume, Majorant, Scene
from woodcock.volume.grid import to_scene

#: Cells along the longest side that are tried, and how many where blocks of them pay.
RESOLUTIONS, FINEST = (8, 16, 32, 48), 96
#: In tentative collisions: what walking through cells at all costs; what a cell does is in hops.py.
WALKING = 0.5


def chosen(scene: Scene, read: Read) -> Majorant:
    """The one under which the mean chord through everything takes the fewest steps.

    read: gives the scene's grids. Raises VolumeError.
    """
    volumes = [volume for volume in scene.volumes if isinstance(volume, GridVolume)]
    media = [_bounded(volume, read(volume.file, volume.grid)) for volume in volumes]
    one = sum(mean_chord(medium.sides) * float(bounds(medium, (1, 1, 1)).max()) for medium in media)
    tried: list[tuple[float, Majorant]] = [(one, GlobalMajorant())]
    for resolution in RESOLUTIONS:
        tried += _cells(media, resolution)
    _, best = min(tried, key=itemgetter(0))
    if isinstance(best, GridMajorant) and best.blocks:
        _, best = min(tried + _cells(media, FINEST), key=itemgetter(0))
    return best


def _bounded(volume: GridVolume, grid: Grid) -> Bounded:
    values = grid.values if grid.values.ndim == 3 else grid.values.max(axis=-1)
    depth, height, width = values.shape
    footprint = 1.0 if volume.interpolation == "trilinear" else 0.5
    return Bounded(
        lambda first, stop: values[first:stop],
        float(np.max(volume.scale)),
        (width, height, depth),
        footprint,
        to_scene(volume, grid),
    )


def _cells(media: Sequence[Bounded], resolution: int) -> list[tuple[float, Majorant]]:
    """Steps along the mean chords of the media's boxes through that many cells, one by one and by blocks."""
    steps = np.full(2, WALKING * len(media))
    for medium in media:
        cells = counts(medium.size, resolution)
        found, step = bounds(medium, cells), pace(medium.sides, cells)
        steps += mean_chord(medium.sides) / step * np.array([crossing(found, step), hops(found, step).cost])
    return [
        (float(cost), GridMajorant(resolution=resolution, blocks=blocks))
        for cost, blocks in zip(steps, (False, True), strict=True)
    ]
