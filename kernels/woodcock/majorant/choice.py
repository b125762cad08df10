"""The majorant of a scene that names none: the one by which its paths take fewer steps."""

from __future__ import annotations

import numpy as np

from woodcock.formats import Grid
from woodcock.layout import Read
from woodcock.majorant.grid import Bounded, bounds, counts, mean_chord
from woodcock.scene import GlobalMajorant, GridMajorant, GridVolume, Majorant, Scene
from woodcock.volume.grid import to_scene

#: Cells along the longest side that are tried.
RESOLUTIONS = (8, 16, 32, 48)
#: In tentative collisions: what a cell costs that a ray crosses, and walking through cells at all. Timed on a cloud at
#: five densities, smoke, fire, and a dense core in haze (`woodcock compare --vary majorant=global,grid`).
CROSSING, WALKING = 0.1, 0.5


def chosen(scene: Scene, read: Read) -> Majorant:
    """The one under which the mean chord through everything takes the fewest steps.

    read: gives the scene's grids. Raises VolumeError.
    """
    grids = [(volume, read(volume.file, volume.grid)) for volume in scene.volumes if isinstance(volume, GridVolume)]
    costs = np.array([_costs(volume, grid) for volume, grid in grids]).reshape(-1, 1 + len(RESOLUTIONS)).sum(axis=0)
    best = int(np.argmin(costs))
    return GridMajorant(resolution=RESOLUTIONS[best - 1]) if best else GlobalMajorant()


def _costs(volume: GridVolume, grid: Grid) -> list[float]:
    """Of the mean chord of a medium's box: under one bound, then under one for each cell, by RESOLUTIONS."""
    values = grid.values if grid.values.ndim == 3 else grid.values.max(axis=-1)
    depth, height, width = values.shape
    place, footprint = to_scene(volume, grid), 1.0 if volume.interpolation == "trilinear" else 0.5
    bounded = Bounded(lambda first, stop: values[first:stop], 1.0, (width, height, depth), footprint, place)
    sides = np.linalg.norm(place[:3, :3], axis=0) * bounded.size
    chord = mean_chord(sides)
    sigma_t = float(np.max(volume.scale))
    costs = [sigma_t * chord * float(values.max())]
    for resolution in RESOLUTIONS:
        cells = counts(bounded.size, resolution)
        crossed = chord * float(np.sum(np.array(cells) / sides))
        costs.append(sigma_t * chord * float(bounds(bounded, cells).mean()) + CROSSING * crossed + WALKING)
    return costs
