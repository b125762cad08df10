"""A scene -> the layout with everything switched on."""

from __future__ import annotations

from functools import cache
from typing import Any

from woodcock.generic import lights, phases, surfaces, view
from woodcock.generic.media import EMISSIONS, SHAPES, media
from woodcock.integrator.full.lights import surface_pdf
from woodcock.integrator.volumetric_path_full import Contents, guiding, without_deltas
from woodcock.layers import layer_names
from woodcock.layout import Kinds, Layout, Read
from woodcock.plan import integrator, settled
from woodcock.program import compose, file_of
from woodcock.scene import (
    BoxShape,
    ConstantVolume,
    GridVolume,
    MixturePhase,
    OrthographicCamera,
    Scene,
    Volume,
)
from woodcock.surface.build import KINDS as SURFACES
from woodcock.surface.compose import MATERIALS
from woodcock.volume.field import STORED

KINDS: Kinds = {
    "integrator": ("volumetric_path",),
    "camera": view.CAMERAS,
    "filter": view.FILTERS,
    "volume": ("constant", "grid"),
    "storage": tuple(STORED),
    "majorant": ("grid",),
    "emission": EMISSIONS[1:],
    "shape": SHAPES,
    "phase": (*phases.LOBES, MixturePhase.model_fields["kind"].default),
    "light": lights.KINDS,
    "surface": SURFACES,
    "material": MATERIALS,
}


def widen(scene: Scene, read: Read) -> Layout:
    """Everything switched on, by random paths whatever the scene asks for: the same mean under the same names.

    Raises VolumeError, ImageError, SceneError.
    """

    @cache
    def once(file: str, grid: str | None) -> Any:
        return read(file, grid)

    scene = settled(scene, once)
    random = integrator(scene) == "volumetric_path"
    volumes = tuple(_meant(volume, i, integrator(scene)) for i, volume in enumerate(scene.volumes))
    held = Contents.of(scene, volumes, once)
    space = held.space
    seen = view.view(scene, space, held.channels)
    assert scene.majorant
    filled = media(held.media, space, scene.majorant, scattering=random)
    of_phases, tables = phases.phases([volume.phase for volume in volumes])
    of_surfaces, shines = surfaces.surfaces(held.bodies, space)
    grids = any(isinstance(volume, GridVolume) for volume in volumes)
    of_lights, pictures = lights.lights(
        held.lights, space, surfaces=shines, equiangular=bool(volumes) and not grids and random
    )
    ours = ("camera", "filter", "phase", "light", "shape")
    return Layout(
        integrator="volumetric_path_full",
        kinds=KINDS,
        channels=3,
        names=layer_names(scene, held.channels),
        records=(
            *seen.records,
            held.bounds(scene),
            *filled.records,
            *of_phases,
            *of_lights,
            guiding(held.media, held.lights, space),
        ),
        buffers={
            "film_sums": seen.sums,
            **filled.buffers,
            **of_surfaces,
            **tables,
            **pictures,
        },
        space=space,
        before_world=(
            "core/coefficient_3.h",
            "core/light_sample.h",
            *filled.files,
            *(file_of(concept, kind) for concept in ours for kind in KINDS[concept]),
        ),
        after_world=(
            phases.text(),
            filled.text,
            "generic/media.h",
            "integrator/full/emission_shares.h",
            *surfaces.parts(),
            seen.text,
            "integrator/full/state.h",
            "generic/clocks.h",
            "integrator/full/spectral_mis.h",
            "integrator/full/walk.h",
            "generic/layers.h",
            "generic/collisions.h",
            "generic/emission.h",
            "integrator/full/grids.h",
            "integrator/guide.h",
            lights.text(),
            "integrator/full/scatter_guided.h",
            lights.SCATTER_PDF,
            surface_pdf(True),
            "integrator/full/surface_scatter_guided.h",
            "integrator/full/surfaces.h",
            "generic/equiangular.h",
            "generic/next_event.h",
        ),
        facts={**filled.facts, **held.series(scene)},
        listed=True,
    )


def _meant(volume: Volume, index: int, solved_by: str) -> Volume:
    """What the scene's integrator takes of a volume."""
    if solved_by == "volumetric_path":
        return without_deltas(volume, f"volumes[{index}]")
    return volume.model_copy(update={"emission": None}) if solved_by == "transmittance" else volume


def generic_layout() -> Layout:
    """The ready program's, whatever scene it is to render."""
    box = ConstantVolume(shape=BoxShape(min=(0.0, 0.0, 0.0), max=(1.0, 1.0, 1.0)), sigma_t=1.0, albedo=0.5)
    camera = OrthographicCamera(origin=(0.5, 0.5, 2.0), target=(0.5, 0.5, 0.5), height=1.0)

    def read(file: str, grid: str | None) -> Any:
        raise AssertionError("there are no grids")

    return widen(Scene(camera=camera, volumes=(box,)), read)


def is_widened(layout: Layout) -> bool:
    """Is everything switched on?"""
    return layout.kinds is KINDS


@cache
def _generic_hash() -> str:
    return compose(generic_layout(), 1).hash


def is_generic(layout: Layout) -> bool:
    """Is its text the ready program's?"""
    return is_widened(layout) and compose(layout, 1).hash == _generic_hash()
