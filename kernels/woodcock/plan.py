"""Which integrator solves a scene, and its layout: the cheapest that is right."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from woodcock.formats import Grid
from woodcock.integrator import emission_absorption, transmittance, volumetric_path, volumetric_path_full
from woodcock.layout import Layout, Read
from woodcock.majorant.choice import chosen
from woodcock.scene import ConstantVolume, MeshShape, RelativeErrorStop, Scene, Volume


def integrator(scene: Scene) -> str:
    """The integrator that the scene asks for; else a deterministic one where it can: nothing scatters, and the picture
    is the beauty alone."""
    if scene.integrator is not None:
        return scene.integrator.kind
    alone = not scene.surfaces and not scene.layers and scene.orders is None
    if not alone or any(_scatters(volume) or _is_mesh(volume) for volume in scene.volumes):
        return "volumetric_path"
    return "emission_absorption" if any(volume.emission for volume in scene.volumes) else "transmittance"


def _scatters(volume: Volume) -> bool:
    return bool(np.max(volume.albedo) > 0)


def _is_mesh(volume: Volume) -> bool:
    return isinstance(volume, ConstantVolume) and isinstance(volume.shape, MeshShape)


def settled(scene: Scene, read: Read) -> Scene:
    """The scene with a majorant, its own or the one that suits it. Raises VolumeError."""
    if scene.majorant:
        return scene
    return scene.model_copy(update={"majorant": chosen(scene, read)})


def lay_out(scene: Scene, read: Read) -> Layout:
    """Lays the scene out for its integrator; `read` gives the grids, each asked for once.

    Raises VolumeError, ImageError, SceneError.
    """

    @cache
    def once(file: str, grid: str | None) -> Grid:
        return read(file, grid)

    match integrator(scene):
        case "transmittance":
            return transmittance.lay_out(scene, once)
        case "emission_absorption":
            return emission_absorption.lay_out(scene, once)
    scene = settled(scene, once)
    if volumetric_path.suits(scene, once):
        layout = volumetric_path.lay_out(scene, once)
    else:
        layout = volumetric_path_full.lay_out(scene, once)
    # Only this contract leaves out pixels.
    return replace(layout, listed=isinstance(scene.stop, RelativeErrorStop))
