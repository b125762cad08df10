"""Lays out any scene for the loop that knows everything; only what the scene uses gets into its text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from woodcock.integrator.full import lights as light_calls
from woodcock.integrator.full import media as media_calls
from woodcock.integrator.full import series
from woodcock.formats.mesh import read_mesh
from woodcock.layers import SUFFIXES, layer_names, order_layers
from woodcock.layout import Kinds, Layout, Read, Record, coloured, instances, module
from woodcock.light import image
from woodcock.light.image import Picture
from woodcock.material.emissive import power
from woodcock.phase.compose import compose as compose_phases
from woodcock.phase.compose import delta_fraction, without_delta
from woodcock.program import file_of
from woodcock.scene import ConstantVolume, EmissiveMaterial, GridVolume, LayerName, MeshShape, Scene, SceneError, Volume
from woodcock.space import Array, Space
from woodcock.surface.build import Body, build, media_at, place
from woodcock.surface.build import corners as corners_of_surfaces
from woodcock.surface.compose import compose as compose_surfaces
from woodcock.volume.compose import compose as compose_media
from woodcock.volume.media import Medium, read_media, strongest
from woodcock.volume.media import corners as corners_of_field

FILM = {"width": "int", "height": "int", "seed": "uint"}
#: The scene's extent, where a ray into it begins; `inside`: meshes of media that hold the camera, one bit each; centre and
#: unit: from the device's space to the scene's.
BOUNDS = {"low": "vector3", "size": "vector3", "inside": "uint", "centre": "vector3", "unit": "float"}
#: For scenes of surfaces alone.
NO_PHASE = """\
static inline vector phase_sample(const struct world *world, integer medium, vector in, real u, real v) { return in; }
static inline real phase_eval(const struct world *world, integer medium, vector in, vector out) { return (real)0.f; }
"""


def lay_out(scene: Scene, read: Read) -> Layout:
    """Raises VolumeError, SceneError."""
    volumes = tuple(map(without_deltas, scene.volumes))
    media = read_media(volumes, read)
    shining = image.read_all(scene.lights)
    meshes = [
        (i, v.shape) for i, v in enumerate(volumes) if isinstance(v, ConstantVolume) and isinstance(v.shape, MeshShape)
    ]
    bodies = place(scene.surfaces, meshes, cache(lambda file: read_mesh(Path(file))))
    corners = _corners(media, bodies)
    space = Space.around(corners, _strongest(scene, shining, media, corners))
    pictures = [light for light in shining if isinstance(light, Picture)]
    many = any(medium.coloured for medium in media) or any(image.is_coloured(picture) for picture in pictures)
    channels = 3 if coloured(scene) or many else 1
    composed = compose_media(media, space, scene.majorant)
    surfaces = compose_surfaces(build(bodies, space), space, channels) if bodies else None
    phase = compose_phases([volume.phase for volume in volumes])
    lights, light_buffers = instances("light", ((f"light_{i}", light) for i, light in enumerate(shining)), space)

    width, height = scene.film.width, scene.film.height
    camera, filter_ = module("camera", scene.camera.kind), module("filter", scene.film.filter.kind)
    records = [
        Record("film", "", "film", FILM, {"width": width, "height": height, "seed": scene.seed}),
        Record(
            "camera", scene.camera.kind, "camera", camera.FIELDS, camera.record(scene.camera, width / height, space)
        ),
        Record("filter", scene.film.filter.kind, "filter", filter_.FIELDS, filter_.record(scene.film.filter)),
        Record(
            "bounds", "", "bounds", BOUNDS, _bounds(corners, space, media_at(bodies, np.array(scene.camera.origin)))
        ),
        *(Record(*numbers) for numbers in composed.records),
        *_shapes(volumes, space),
        *phase.records,
        *lights,
    ]
    grids = any(isinstance(volume, GridVolume) for volume in volumes)
    constants = any(isinstance(volume, ConstantVolume) for volume in volumes)
    kinds: Kinds = {
        "integrator": ("volumetric_path",),
        "camera": (scene.camera.kind,),
        "filter": (scene.film.filter.kind,),
        **composed.kinds,
        "shape": tuple(dict.fromkeys(volume.shape.kind for volume in volumes if isinstance(volume, ConstantVolume))),
        "phase": phase.kinds,
        "light": tuple(dict.fromkeys(light.kind for light in scene.lights)),
    }
    emissive = surfaces is not None and surfaces.emits
    if surfaces:
        kinds |= surfaces.kinds
    sampled = [light for light in lights if module("light", light.kind).SAMPLED]
    found_by_both = emissive or any(module("light", light.kind).ON_ESCAPE for light in sampled)
    local = [light for light in lights if module("light", light.kind).LOCAL]
    equiangular = bool(local) and constants and not grids
    spectral = any(not medium.grey for medium in media)
    ours = ("camera", "filter", "phase", "light", "shape")
    files = [*composed.files, *(file_of(concept, kind) for concept in ours for kind in kinds[concept])]

    after = [
        "core/box.h",
        phase.text if volumes else NO_PHASE,
        composed.text,
        *(surfaces.parts if surfaces else ()),
        _camera(scene),
        _layers(scene, channels),
        "integrator/full/state.h",
        media_calls.clocks(volumes) if constants else media_calls.no_clocks(),
        f"integrator/full/{'spectral_mis' if spectral else 'grey'}.h",
        "integrator/full/walk.h",
        f"integrator/full/{'layers' if _wants_layers(scene) else 'no_layers'}.h",
        media_calls.albedo(volumes),
    ]
    after = [part for part in after if part]
    emits = any(volume.emission is not None for volume in volumes)
    after += (
        [media_calls.emission(volumes), "integrator/full/emission.h"] if emits else ["integrator/full/no_emission.h"]
    )
    after += (
        [
            media_calls.grids(
                volumes, scene.majorant.kind, "world->majorant_grid_bounds, " if scene.majorant.kind == "grid" else ""
            ),
            "integrator/full/grids.h",
        ]
        if grids
        else ["integrator/full/no_grids.h"]
    )
    after.append(light_calls.escape(lights, len(sampled) + emissive))
    after.append(_scatter_pdf(found_by_both))
    if sampled or emissive:
        after.append(light_calls.choose(lights, emissive))
    if surfaces:
        after += [light_calls.surface_pdf(emissive), "integrator/full/surfaces.h"]
    else:
        after.append("integrator/full/no_surfaces.h")
    if sampled or emissive:
        if equiangular:
            after += [light_calls.places(lights), media_calls.spans(volumes), "integrator/full/equiangular.h"]
        else:
            after.append("integrator/full/no_equiangular.h")
        after.append("integrator/full/next_event.h")
    else:
        after += ["integrator/full/no_equiangular.h", "integrator/full/no_next_event.h"]
    return Layout(
        integrator="volumetric_path_full",
        kinds=kinds,
        channels=channels,
        names=layer_names(scene, channels),
        records=tuple(records),
        buffers={
            **composed.buffers,
            **({n: a for n, (_, a) in surfaces.buffers.items()} if surfaces else {}),
            **phase.buffers,
            **light_buffers,
        },
        space=space,
        before_world=(f"core/coefficient_{3 if spectral else 1}.h", "core/light_sample.h", *files),
        after_world=tuple(after),
        facts={
            **composed.facts,
            "norm": series.norm(scene, media, corners),
            "unscattered": series.unscattered(shining, scene, media, corners),
        },
    )


def _corners(media: Sequence[Medium], bodies: Sequence[Body]) -> Array:
    """(n, 3) points of the scene whose hull holds everything that is finite."""
    found = [corners_of_surfaces(bodies)] if bodies else []
    for medium in media:
        if medium.density:
            found.append(corners_of_field(medium.density, medium.to_scene(medium.density)))
        elif isinstance(medium.volume, ConstantVolume) and not isinstance(medium.volume.shape, MeshShape):
            found.append(module("shape", medium.volume.shape.kind).corners(medium.volume.shape))
    return np.concatenate(found)


def _shapes(volumes: Sequence[Volume], space: Space) -> list[Record]:
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


def _camera(scene: Scene) -> str:
    camera, filter_ = scene.camera.kind, scene.film.filter.kind
    lens = "lens_u, lens_v, " if getattr(module("camera", camera), "LENS", False) else ""
    return f"""\
static inline void camera_ray(const struct world *world, real u, real v, real lens_u, real lens_v, vector *anchor,
                              vector *direction, real *start) {{
    camera_{camera}_ray(&world->scene->camera, u, v, {lens}anchor, direction, start);
}}
static inline real filter_offset(const struct world *world, real u) {{
    return filter_{filter_}_offset(&world->scene->filter, u);
}}
"""


def _wants_layers(scene: Scene) -> bool:
    return bool(scene.layers) or scene.orders is not None


def _layers(scene: Scene, channels: int) -> str:
    """The state of the layers beside the beauty, and at which channel after it each begins."""
    if not _wants_layers(scene):
        return "enum { LAYERS = 0 };\ntypedef struct { int unused; } layer_values;\n"
    orders = len(order_layers(scene))
    start = orders * channels
    at: dict[LayerName, int] = {}
    for layer in scene.layers:
        at[layer] = start
        start += len(SUFFIXES[layer]) or channels
    constants = [f"LAYERS = {start}", f"ORDERS = {orders}"]
    constants += [f"{layer.upper()} = {at.get(layer, -1)}" for layer in SUFFIXES]
    return f"""\
enum {{ {", ".join(constants)} }};
typedef struct {{
    real value[LAYERS], lead; // lead: from the camera to the segment at which the path began
    vector start;
    mask unmet, probing;      // nothing met yet; a walk along the camera ray
}} layer_values;
"""


def _scatter_pdf(found_by_both: bool) -> str:
    value = "phase_eval(world, medium, in, out)" if found_by_both else "(real)1e30f"
    return f"""\
static inline real scatter_pdf(const struct world *world, integer medium, vector in, vector out) {{ return {value}; }}
"""


def without_deltas(volume: Volume) -> Volume:
    """The same medium without what its phase function sends straight on, for that is no scattering at all."""
    share = delta_fraction(volume.phase)
    if share == 0:
        return volume
    key = "sigma_t" if isinstance(volume, ConstantVolume) else "scale"
    if isinstance(volume, GridVolume) and volume.albedo_grid is not None:
        raise SceneError("albedo_grid: cannot be used with a phase function that goes straight on (g above 0.9999)")
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
