"""The majorant of a scene that names none: the one by which its paths take fewer steps."""

from __future__ import annotations

import numpy as np

from woodcock.formats import Grid
from woodcock.layout import Read
from woodcock.majorant.grid import Bounded, bounds, counts
from woodcock.scene import GlobalMajorant, GridMajorant, GridVolume, Majorant, Scene
from woodcock.volume.grid import to_scene

#: A flight from cell to cell costs as much as so many steps under one bound, and each of its own steps as so many:
#: where one bound leaves the scene to the small loop, and else. Timed on a cloud, smoke, fire and a simulation of
#: combustion, each at three densities (`woodcock compare --vary majorant=global,grid`).
SMALL_LOOP, FULL_LOOP = (20.0, 1.2), (5.0, 1.0)


def chosen(scene: Scene, read: Read, *, small_loop: bool) -> Majorant:
    """Tentative collisions along a ray through everything, under one bound and under one for each cell, decide.

    read: gives the scene's grids; small_loop: would that render the scene under one bound? Raises VolumeError.
    """
    grids = [(volume, read(volume.file, volume.grid)) for volume in scene.volumes if isinstance(volume, GridVolume)]
    depths = np.array([_depths(volume, grid) for volume, grid in grids]).reshape(-1, 2)
    whole, cells = depths.sum(axis=0)
    begin, step = SMALL_LOOP if small_loop else FULL_LOOP
    return GridMajorant() if begin + step * cells < whole else GlobalMajorant()


def _depths(volume: GridVolume, grid: Grid) -> tuple[float, float]:
    """Optical depth of the mean chord through a medium's box, of its largest σ_t and of the mean over cells of theirs.

    The mean chord of a convex body is 4 V / S (Cauchy).
    """
    values = grid.values if grid.values.ndim == 3 else grid.values.max(axis=-1)
    depth, height, width = values.shape
    place, footprint = to_scene(volume, grid), 1.0 if volume.interpolation == "trilinear" else 0.5
    bounded = Bounded(lambda first, stop: values[first:stop], 1.0, (width, height, depth), footprint, place)
    cells = bounds(bounded, counts(bounded.size, GridMajorant().resolution))
    sides = np.linalg.norm(place[:3, :3], axis=0) * bounded.size
    sigma_t = float(np.max(volume.scale)) * 2 / float(np.sum(1 / sides))
    return sigma_t * float(cells.max()), sigma_t * float(cells.mean())
