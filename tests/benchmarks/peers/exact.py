"""Pictures of absorption alone, in float64, at the middles of pixels: integrated cell by cell, by no code of Woodcock's
device."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from tests.kernels.ray_oracles import Gridded, optical_depth

from woodcock.camera import perspective
from woodcock.formats import read_grid
from woodcock.scene import ConstantLight, GridVolume, PerspectiveCamera, Scene
from woodcock.space import Array
from woodcock.volume.grid import to_scene

#: Pixels along a side that are computed.
SIDE = 16


def transmittances(scene: Scene, folder: Path) -> tuple[Array, Array, Array]:
    """Rows and columns of pixels that lie evenly over the picture, and their radiance, each (SIDE²,)."""
    (volume,), (light,), camera = scene.volumes, scene.lights, scene.camera
    assert isinstance(volume, GridVolume)
    assert isinstance(light, ConstantLight)
    assert isinstance(camera, PerspectiveCamera)
    grid = read_grid(folder / volume.file, volume.grid)
    medium = Gridded(grid.values.astype(float), to_scene(volume, grid), volume.scale)
    width, height = scene.film.width, scene.film.height
    rows, columns = (
        each.ravel()
        for each in np.meshgrid(*((np.arange(SIDE) + 0.5) * size // SIDE for size in (height, width)), indexing="ij")
    )
    origin, along = perspective.ray(camera, width / height, (columns + 0.5) / width, (rows + 0.5) / height)
    depths = [optical_depth([medium], np.concatenate([origin, each]))[0] for each in along]
    return rows.astype(int), columns.astype(int), np.exp(-np.array(depths)) * np.mean(light.radiance)
