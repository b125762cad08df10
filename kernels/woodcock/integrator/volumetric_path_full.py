"""Lays out any scene for the loop that knows everything; only what the scene uses gets into its text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from woodcock.formats.mesh import read_mesh
from woodcock.integrator import guide
from woodcock.integrator.full import parts, series
from woodcock.layers import layer_names
from woodcock.layout import Kinds, Layout, Read, Record, coloured, instances, module
from woodcock.light import image
from woodcock.material.emissive import power
from woodcock.phase.compose import compose as compose_phases
from woodcock.phase.compose import delta_fraction, without_delta
from woodcock.program import file_of
from woodcock.scene import ConstantVolume, EmissiveMaterial, GridVolume, Light, MeshShape, Scene, SceneError, Volume
from woodcock.space import Array, Space
from woodcock.surface.build import Body, build, media_at, place
from woodcock.surface.build import corners as corners_of_surfaces
from woodcock.surface.compose import compose as compose_surfaces
from woodcock.volume.compose import compose as compose_media
from woodcock.volume.media import Medium, read_media, strongest
from woodcock.volume.media import corners as corners_of_field

FILM = {"width": "int", "height": "int", "seed": "uint"}
#: The scene's extent, where a ray into it begins; `inside`: meshes of media that hold the camera, one bit each; centre
#: and unit: from the device's space to the scene's.
BOUNDS = {"low": "vector3", "size": "vector3", "inside": "uint", "centre": "vector3", "unit": "float"}
#: For scenes of surfaces alone.
NO_PHASE = """\
static inline vector phase_sample(const struct world *world, integer medium, vector in, real u, real v) { return in; }
static inline real phase_eval(const struct world *world, integer medium, vector in, vector out) { return (real)0.f; }
"""


@dataclass(frozen=True)
class Contents:
    """What is in a scene, read and placed. corners: (n, 3) of what is finite; channels: that the picture needs."""

    media: tuple[Medium, ...]
    lights: list[Light | image.Picture]
    bodies: tuple[Body, ...]
    corners: Array
    space: Space
    channels: int

    @classmethod
    def of(cls, scene: Scene, volumes: tuple[Volume, ...], read: Read) -> Contents:
        """volumes: in place of the scene's. Raises VolumeError, ImageError, MeshError, SceneError."""
        media = read_media(volumes, read)
        lights = image.read_all(scene.lights)
        bodies = place(scene.surfaces, _meshes(volumes), cache(lambda file: read_mesh(Path(file))))
        corners = _corners(media, bodies)
        space = Space.around(corners, _strongest(scene, lights, media, corners))
        many = any(medium.coloured for medium in media) or any(map(image.is_coloured, lights))
        return cls(media, lights, bodies, corners, space, 3 if coloured(scene) or many else 1)

    def bounds(self, scene: Scene) -> Record:
        inside = media_at(self.bodies, np.array(scene.camera.origin))
        return Record("bounds", "", "bounds", BOUNDS, _bounds(self.corners, self.space, inside))

    def series(self, scene: Scene) -> dict[str, Any]:
        """Facts of the Neumann series."""
        return {
            "norm": series.norm(scene, self.media, self.corners),
            "unscattered": series.unscattered(self.lights, scene, self.media, self.corners),
        }


def lay_out(scene: Scene, read: Read) -> Layout:
    """Raises VolumeError, ImageError, SceneError."""
    volumes = tuple(without_deltas(volume, f"volumes[{i}]") for i, volume in enumerate(scene.volumes))
    held = Contents.of(scene, volumes, read)
    media, lights, bodies, space, channels = held.media, held.lights, held.bodies, held.space, held.channels
    surfaces = compose_surfaces(build(bodies, space), space, channels) if bodies else None
    phase = compose_phases([volume.phase for volume in volumes])
    shining, light_buffers = instances("light", ((f"light_{i}", light) for i, light in enumerate(lights)), space)
    uses = parts.Uses(
        scene=scene,
        volumes=volumes,
        channels=channels,
        lights=tuple(shining),
        spectral=any(not medium.grey for medium in media),
        surfaces=surfaces is not None,
        shining=surfaces is not None and surfaces.emits,
    )
    assert scene.majorant, "the plan settles it"
    composed = compose_media(
        media,
        space,
        scene.majorant,
        control=uses.control,
        residual=uses.transmittance == "residual_ratio",
        glow=True,
    )
    kinds: Kinds = {
        "integrator": ("volumetric_path",),
        "camera": (scene.camera.kind,),
        "filter": (scene.film.filter.kind,),
        **composed.kinds,
        **_estimators(uses),
        "shape": tuple(dict.fromkeys(volume.shape.kind for volume in volumes if isinstance(volume, ConstantVolume))),
        "phase": phase.kinds,
        "light": tuple(dict.fromkeys(light.kind for light in lights)),
        **(surfaces.kinds if surfaces else {}),
    }
    ours = ("camera", "filter", "phase", "light", "shape")
    return Layout(
        integrator="volumetric_path_full",
        kinds=kinds,
        channels=channels,
        names=layer_names(scene, channels),
        records=(
            *frame(scene, space),
            held.bounds(scene),
            *composed.records,
            *shapes(volumes, space),
            *phase.records,
            *shining,
            *([guiding(media, lights, space)] if uses.guided else []),
        ),
        buffers={
            **composed.buffers,
            **({name: array for name, (_, array) in surfaces.buffers.items()} if surfaces else {}),
            **phase.buffers,
            **light_buffers,
        },
        space=space,
        before_world=(
            f"core/coefficient_{3 if uses.spectral else 1}.h",
            "core/light_sample.h",
            *composed.files,
            *(file_of(concept, kind) for concept in ours for kind in kinds[concept]),
        ),
        after_world=(
            "core/box.h",
            phase.text if volumes else NO_PHASE,
            *((composed.text,) if volumes else ()),
            *(surfaces.parts if surfaces else ()),
            *parts.of(uses, dense_glow=composed.dense_glow),
        ),
        facts={**composed.facts, **held.series(scene)},
    )


def _estimators(uses: parts.Uses) -> Kinds:
    """How flights find collisions and walks what gets through: in constant media in closed form."""
    grids, constants = uses.grids, uses.constants
    flights = (*("analytic",) * constants, *(uses.free_flight,) * grids)
    walks = (*("exact",) * constants, *(uses.transmittance,) * grids)
    return ({"free_flight": flights} if flights else {}) | ({"transmittance": walks} if walks and uses.walks else {})


def guiding(media: Sequence[Medium], lights: Sequence[Light | image.Picture], space: Space) -> Record:
    """What directions are guided by."""
    depth = sum(space.coefficient(float(medium.bound.max())) for medium in media)
    return guide.record([medium.volume for medium in media], [light.kind for light in lights], depth)


def frame(scene: Scene, space: Space) -> list[Record]:
    """What rays begin with: film, camera, filter."""
    width, height = scene.film.width, scene.film.height
    camera, filter_ = module("camera", scene.camera.kind), module("filter", scene.film.filter.kind)
    values = camera.record(scene.camera, width / height, space)
    return [
        Record("film", "", "film", FILM, {"width": width, "height": height, "seed": scene.seed}),
        Record("camera", scene.camera.kind, "camera", camera.FIELDS, values),
        Record("filter", scene.film.filter.kind, "filter", filter_.FIELDS, filter_.record(scene.film.filter)),
    ]


def _meshes(volumes: Sequence[Volume]) -> list[tuple[int, MeshShape]]:
    shapes = [(i, volume.shape) for i, volume in enumerate(volumes) if isinstance(volume, ConstantVolume)]
    return [(i, shape) for i, shape in shapes if isinstance(shape, MeshShape)]


def _corners(media: Sequence[Medium], bodies: Sequence[Body]) -> Array:
    """(n, 3) points of the scene whose hull holds everything that is finite."""
    found = [corners_of_surfaces(bodies)] if bodies else []
    for medium in media:
        if medium.density:
            found.append(corners_of_field(medium.density, medium.to_scene(medium.density)))
        elif isinstance(medium.volume, ConstantVolume) and not isinstance(medium.volume.shape, MeshShape):
            found.append(module("shape", medium.volume.shape.kind).corners(medium.volume.shape))
    return np.concatenate(found)


def shapes(volumes: Sequence[Volume], space: Space) -> list[Record]:
    """Where constant media are."""
    found = []
    for index, volume in enumerate(volumes):
        if isinstance(volume, ConstantVolume):
            kind = module("shape", volume.shape.kind)
            mesh = isinstance(volume.shape, MeshShape)
            values = kind.record(index) if mesh else kind.record(volume.shape, space)
            found.append(Record("shape", volume.shape.kind, f"shape_{index}", kind.FIELDS, values))
    return found


def _strongest(scene: Scene, lights: Sequence[Any], media: Sequence[Medium], corners: Array) -> float:
    """About the largest radiance in the scene: where the space's unit of radiance is put."""
    size = float(np.ptp(corners, axis=0).max())
    found = [0.0, *(power(s.material) for s in scene.surfaces if isinstance(s.material, EmissiveMaterial))]
    found += [0.0, *(strongest(medium, size) for medium in media)]
    for light in lights:
        kind = module("light", light.kind)
        strength = float(np.max(kind.strength(light)))
        found.append(strength / size**2 if kind.LOCAL and size > 0 else strength)
    return min(max(found), math.inf)


def _bounds(corners: Array, space: Space, inside: int) -> dict[str, Any]:
    """A little larger than the scene, so that nothing that lies on its border is cut off."""
    points = space.point(corners)
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 1e-4 * float((high - low).max())
    return {
        "low": low - margin,
        "size": high - low + 2 * margin,
        "inside": inside,
        "centre": space.centre,
        "unit": math.ldexp(1.0, space.length_exponent),
    }


def without_deltas(volume: Volume, where: str) -> Volume:
    """The same medium without what its phase function sends straight on, for that is no scattering at all.

    Raises SceneError, which names the volume by `where`.
    """
    share = delta_fraction(volume.phase)
    if share == 0:
        return volume
    key = "sigma_t" if isinstance(volume, ConstantVolume) else "scale"
    if isinstance(volume, GridVolume) and volume.albedo_grid is not None:
        raise SceneError(f"{where}.albedo_grid: cannot go with a phase function that goes straight on (g above 0.9999)")
    sigma_t, albedo = np.broadcast_arrays(getattr(volume, key), volume.albedo)
    kept = 1 - share * albedo
    scattered = np.divide(albedo * (1 - share), kept, out=np.zeros(np.shape(albedo)), where=kept > 0)
    changes: dict[str, Any] = {
        key: _spectrum(sigma_t * kept),
        "albedo": _spectrum(scattered),
        "phase": without_delta(volume.phase),
    }
    return volume.model_copy(update=changes)


def _spectrum(value: Array) -> float | tuple[float, ...]:
    return float(value) if value.ndim == 0 else tuple(float(v) for v in value)
