"""Which integrator solves a scene, and its layout: the cheapest that is right."""

from __future__ import annotations

from functools import cache

from woodcock.formats import Grid
from woodcock.integrator import volumetric_path, volumetric_path_full
from woodcock.layout import Layout, Read
from woodcock.scene import Scene


def lay_out(scene: Scene, read: Read) -> Layout:
    """Lays the scene out for its integrator; `read` gives the grids, each asked for once.

    Raises VolumeError, SceneError.
    """

    @cache
    def once(file: str, grid: str | None) -> Grid:
        return read(file, grid)

    if volumetric_path.suits(scene, once):
        return volumetric_path.lay_out(scene, once)
    return volumetric_path_full.lay_out(scene, once)
