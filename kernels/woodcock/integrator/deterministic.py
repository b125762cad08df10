"""Lays scenes out for the integrators without random numbers. They know cameras, filters, media and what lies behind
them, but nothing that scatters.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from woodcock.integrator import deterministic_text as text
from woodcock.layers import layer_names
from woodcock.layout import Kinds, Layout, Read, Record, coloured, instances, module
from woodcock.light import image
from woodcock.program import file_of
from woodcock.scene import (
    BlackbodyEmission,
    ConstantVolume,
    EmissionAbsorptionIntegrator,
    GlobalMajorant,
    MeshShape,
    Scene,
    SceneError,
)
from woodcock.space import Array, Space
from woodcock.volume.compose import compose
from woodcock.volume.media import Medium, corners, read_media, strongest

FILM = {"width": "int", "height": "int", "seed": "uint"}


def lay_out(scene: Scene, read: Read, integrator: str) -> Layout:
    """integrator: transmittance or emission_absorption. Raises VolumeError, SceneError."""
    _check(scene, integrator)
    media, shining = read_media(scene.volumes, read), image.read_all(scene.lights)
    points = np.concatenate([_corners(medium) for medium in media])
    space = Space.around(points, _strongest(shining, media, points))
    grey = all(medium.grey for medium in media)
    many = any(medium.coloured for medium in media) or any(map(image.is_coloured, shining))
    channels = 3 if coloured(scene) or many else 1
    composed = compose(media, space, GlobalMajorant(), pairs=integrator == "transmittance")
    lights, light_buffers = instances("light", ((f"light_{i}", light) for i, light in enumerate(shining)), space)

    width, height = scene.film.width, scene.film.height
    camera, filter_ = module("camera", scene.camera.kind), module("filter", scene.film.filter.kind)
    tolerance = getattr(scene.integrator, "tolerance", EmissionAbsorptionIntegrator().tolerance)
    records = [
        Record("film", "", "film", FILM, {"width": width, "height": height, "seed": scene.seed}),
        Record(
            "camera", scene.camera.kind, "camera", camera.FIELDS, camera.record(scene.camera, width / height, space)
        ),
        Record("filter", scene.film.filter.kind, "filter", filter_.FIELDS, filter_.record(scene.film.filter)),
        Record("integrator", "", "integrator", {"tolerance": "float"}, {"tolerance": tolerance}),
        *(record for record in composed.records if record.concept not in ("tracking", "majorant")),
        *lights,
    ]
    for index, volume in enumerate(scene.volumes):
        if isinstance(volume, ConstantVolume):
            kind = module("shape", volume.shape.kind)
            values = kind.record(volume.shape, space)
            records.append(Record("shape", volume.shape.kind, f"shape_{index}", kind.FIELDS, values))

    kinds: Kinds = {
        "integrator": (integrator,),
        "camera": (scene.camera.kind,),
        "filter": (scene.film.filter.kind,),
        **{concept: kinds for concept, kinds in composed.kinds.items() if concept != "majorant"},
        "light": tuple(dict.fromkeys(light.kind for light in scene.lights)),
    }
    emission = integrator == "emission_absorption"
    described = [_described(index, medium, emission) for index, medium in enumerate(media)]
    shapes = tuple(dict.fromkeys(medium.shape[0] for medium in described if medium.shape))
    kinds |= {"shape": shapes} if shapes else {}
    files = [file for file in composed.files if not file.startswith("majorant/")]
    files += [file_of(concept, kind) for concept in ("camera", "filter", "light") for kind in kinds[concept]]
    sides = max((n for medium in media for field in _fields(medium) for n in field), default=0)
    return Layout(
        integrator=integrator,
        kinds=kinds,
        channels=channels,
        names=layer_names(scene, channels),
        records=tuple(records),
        buffers={**composed.buffers, **light_buffers},
        space=space,
        before_world=(*text.files(described, grey=grey), *files),
        after_world=(
            text.camera(scene.camera.kind, scene.film.filter.kind, lens=getattr(camera, "LENS", False), sides=sides),
            text.radiance([_radiance(light) for light in lights if module("light", light.kind).ON_ESCAPE]),
            composed.text,
            text.walks(described, emission=emission),
        ),
        facts=composed.facts,
    )


def _check(scene: Scene, integrator: str) -> None:
    """Raises SceneError for what these integrators do not know."""
    if scene.surfaces:
        raise SceneError(f"surfaces: the integrator {integrator} has none; volumetric_path does")
    if scene.layers or scene.orders is not None:
        raise SceneError(f"layers and orders: the integrator {integrator} has none; volumetric_path does")
    for index, volume in enumerate(scene.volumes):
        if isinstance(volume, ConstantVolume) and isinstance(volume.shape, MeshShape):
            where = f"volumes[{index}].shape"
            raise SceneError(
                f"{where}: the integrator {integrator} knows boxes and spheres; volumetric_path, meshes too"
            )


def _corners(medium: Medium) -> Array:
    """(8, 3), of a box around it, in the scene."""
    if medium.density:
        return corners(medium.density, medium.to_scene(medium.density))
    assert isinstance(medium.volume, ConstantVolume)
    return np.asarray(module("shape", medium.volume.shape.kind).corners(medium.volume.shape))


def _strongest(lights: Sequence[Any], media: Sequence[Medium], points: Array) -> float:
    """About the largest radiance of the scene."""
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    found = [strongest(medium, extent) for medium in media]
    for light in lights:
        kind = module("light", light.kind)
        if kind.ON_ESCAPE:
            found.append(float(np.max(kind.strength(light))))
    return max(found, default=0.0)


def _fields(medium: Medium) -> list[tuple[int, int, int]]:
    return [field.size for field in (medium.density, medium.albedo, medium.emission) if field]


def _described(index: int, medium: Medium, emission: bool) -> text.Medium:
    """emission: is it asked for? Then the grids that it depends on count, too."""
    if medium.density is None:
        assert isinstance(medium.volume, ConstantVolume)
        shape = f"world->scene->shape_{index}"
        kind = medium.volume.shape.kind
        return text.Medium(f"{shape}.to_local", shape=(kind, shape), emits=emission and medium.emits)
    fields = {"density": medium.density}
    if emission and medium.emission:
        fields["emission"] = medium.emission
    if emission and medium.albedo and isinstance(medium.volume.emission, BlackbodyEmission):
        fields["albedo"] = medium.albedo
    name = f"medium_{index}"
    lattices = tuple(
        text.Lattice(f"{name}_{part}_field", field.nearest)
        for part, field in fields.items()
        if medium.place(part) == part
    )
    return text.Medium(f"world->scene->{name}.to_local", lattices=lattices, emits=emission and medium.emits)


def _radiance(light: Record) -> str:
    """What a ray of `direction` finds of a light behind everything."""
    names = getattr(module("light", light.kind), "BUFFERS", ())
    buffers = "".join(f"world->light_{light.kind}_{name}, " for name in names)
    return f"light_{light.kind}_radiance(&world->scene->{light.member}, {buffers}direction)"
