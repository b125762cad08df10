"""Lays out a scene of one grey medium between lights at infinity: the loop with the least in it.

Every other scene takes `volumetric_path_full`; a test holds the two to each other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from woodcock.integrator import guide
from woodcock.layers import layer_names
from woodcock.layout import Buffers, Kinds, Layout, Read, Record, coloured, instances, module
from woodcock.majorant import grid as majorant_grid
from woodcock.majorant.grid import Bounded
from woodcock.program import file_of
from woodcock.scene import (
    BoxFilter,
    BoxShape,
    ConstantVolume,
    DeltaFreeFlight,
    GlobalMajorant,
    GridMajorant,
    GridVolume,
    HenyeyGreensteinPhase,
    RatioTransmittance,
    Scene,
    Volume,
)
from woodcock.space import Array, Space
from woodcock.volume.field import CHUNK

CAMERAS = ("perspective", "orthographic", "spherical")
PHASES = ("isotropic", "henyey_greenstein")
LIGHTS = ("constant", "directional")
#: Above this a Henyey–Greenstein lobe is a forward delta.
SHARPEST = 0.9999


def suits(scene: Scene, read: Read) -> bool:
    """Is the scene one grey medium without emission between lights at infinity, and its picture the beauty alone?"""
    if len(scene.volumes) != 1 or scene.surfaces or scene.layers or scene.orders is not None:
        return False
    (volume,) = scene.volumes
    if isinstance(volume, ConstantVolume):
        plain = isinstance(volume.shape, BoxShape) and not isinstance(volume.sigma_t, tuple)
    else:
        plain = volume.interpolation == "trilinear" and volume.albedo_grid is None and volume.storage_error == 0
        values = read(volume.file, volume.grid).values
        plain = plain and not isinstance(volume.scale, tuple) and values.ndim == 3 and values.nbytes <= CHUNK
        plain = plain and scene.free_flight in (None, DeltaFreeFlight())
        plain = plain and scene.transmittance in (None, RatioTransmittance())
    sharp = isinstance(volume.phase, HenyeyGreensteinPhase) and volume.phase.g > SHARPEST
    return (
        plain
        and volume.emission is None
        and volume.phase.kind in PHASES
        and not sharp
        and scene.camera.kind in CAMERAS
        and all(light.kind in LIGHTS for light in scene.lights)
        and (scene.majorant == GlobalMajorant() or isinstance(volume, GridVolume))
        and scene.film.filter == BoxFilter()
    )


class _Medium(NamedTuple):
    """A volume, read: size, its extent in local space; bound, on σ_t; record, its numbers in a space; bounded, what a
    majorant of cells needs of it."""

    kinds: Kinds
    to_scene: Array
    size: tuple[int, ...]
    bound: float
    record: Callable[[Space], dict[str, Any]]
    buffers: Buffers
    bounded: Bounded | None = None

    def facts(self, volume: Volume) -> dict[str, Any]:
        """What the report says of the medium."""
        scatters, coloured = self.bound > 0 and np.max(volume.albedo) > 0, np.size(volume.albedo) > 1
        return {
            "kind": volume.kind,
            "sigma_t": [self.bound],
            "storage": {"density": {"kind": self.kinds["storage"][0], "error": 0.0}} if self.bounded else {},
            "emits": False,
            "scatters": bool(scatters),
            "coloured": coloured,
        }

    def corners(self) -> Array:
        """(8, 3), in the scene."""
        corners = np.array(list(np.ndindex(2, 2, 2))) * np.array(self.size)
        return np.asarray(corners @ self.to_scene[:3, :3].T + self.to_scene[:3, 3])


def _medium(volume: Volume, read: Read) -> _Medium:
    kind = module("volume", volume.kind)
    if isinstance(volume, ConstantVolume):
        kinds: Kinds = {"volume": ("constant",), "free_flight": ("analytic",), "transmittance": ("exact",)}
        assert isinstance(volume.sigma_t, float)
        return _Medium(
            kinds, kind.to_scene(volume), (1, 1, 1), volume.sigma_t, lambda space: kind.record(volume, space), {}
        )
    grid = read(volume.file, volume.grid)
    largest, storage = kind.check(grid, volume.file), kind.storage(grid.values)
    assert isinstance(volume.scale, float)
    place, size = kind.to_scene(volume, grid), grid.values.shape[::-1]
    return _Medium(
        {"storage": (storage,), "volume": ("grid",), "free_flight": ("delta",), "transmittance": ("ratio",)},
        place,
        size,
        volume.scale * largest,
        lambda space: kind.record(volume, grid, largest, space),
        {"density": kind.bricks(grid.values, storage)},
        Bounded(lambda a, b: grid.values[a:b].astype(np.float32, copy=False), volume.scale, size, 1.0, place),
    )


class _Majorant(NamedTuple):
    """Its record, buffers and files beside its kind's, and what densities are relative to: σ_t of the largest under one
    bound; 1 / length of the device under one for each cell."""

    record: Record
    buffers: Buffers
    relative: float
    files: tuple[str, ...] = ()


def _majorant(scene: Scene, medium: _Medium, space: Space) -> _Majorant:
    if not isinstance(scene.majorant, GridMajorant) or medium.bounded is None:
        kind = module("majorant", "global")
        return _Majorant(
            Record("majorant", "global", "majorant", kind.FIELDS, kind.record(medium.bound, space)), {}, 1.0
        )
    cells = majorant_grid.counts(medium.size, scene.majorant.resolution)
    error = majorant_grid.MARGIN * float(np.ldexp(1.0, space.length_exponent))  # the device's space is about one long
    bounds = majorant_grid.bounds(medium.bounded, cells, error)
    through, kept = majorant_grid.cut(bounds, medium.bounded.sides, space, blocks=scene.majorant.blocks)
    values = majorant_grid.record(cells, np.array(medium.size, float))
    record = Record("majorant", "grid", "majorant", majorant_grid.FIELDS, values)
    return _Majorant(record, {"majorant_grid_bounds": kept}, space.coefficient(medium.bound), (through,))


def lay_out(scene: Scene, read: Read) -> Layout:
    """Raises VolumeError."""
    (volume,) = scene.volumes
    medium = _medium(volume, read)
    strongest = max((float(module("light", light.kind).strength(light).max()) for light in scene.lights), default=0.0)
    space = Space.around(medium.corners(), strongest)

    film = {"width": scene.film.width, "height": scene.film.height, "seed": scene.seed}
    camera, aspect = module("camera", scene.camera.kind), scene.film.width / scene.film.height
    majorant, numbers = _majorant(scene, medium, space), medium.record(space)
    numbers |= {name: number * majorant.relative for name, number in numbers.items() if name == "relative"}
    phase = module("phase", volume.phase.kind)
    lights, _ = instances("light", ((f"light_{i}", light) for i, light in enumerate(scene.lights)), space)
    records = [
        Record("film", "", "film", {"width": "int", "height": "int", "seed": "uint"}, film),
        Record("camera", scene.camera.kind, "camera", camera.FIELDS, camera.record(scene.camera, aspect, space)),
        Record("volume", volume.kind, "volume", module("volume", volume.kind).FIELDS, numbers),
        majorant.record,
        Record("phase", volume.phase.kind, "phase", phase.FIELDS, phase.record(volume.phase)),
        *lights,
    ]

    kinds = {
        "integrator": ("volumetric_path",),
        "camera": (scene.camera.kind,),
        **medium.kinds,
        "majorant": (majorant.record.kind,),
        "phase": (volume.phase.kind,),
        "light": tuple(dict.fromkeys(light.kind for light in scene.lights)),
    }
    if all(module("light", kind).ON_ESCAPE for kind in kinds["light"]):
        del kinds["transmittance"]
    guided = "transmittance" in kinds and guide.guides([volume], kinds["light"])
    if guided:
        records.append(guide.record([volume], kinds["light"], space.coefficient(medium.bound)))
    files = [file_of(concept, kind) for concept, kinds in kinds.items() if concept != "integrator" for kind in kinds]
    channels = 3 if coloured(scene) else 1
    next_event = "integrator/next_event.h" if "transmittance" in kinds else "integrator/no_next_event.h"
    return Layout(
        integrator="volumetric_path",
        kinds=kinds,
        channels=channels,
        names=layer_names(scene, channels),
        records=tuple(records),
        buffers={**medium.buffers, **majorant.buffers},
        space=space,
        before_world=(*majorant.files, *files),
        facts={"media": [medium.facts(volume)]},
        after_world=(
            _dispatch(kinds, medium.buffers, lights),
            f"integrator/flight_{majorant.record.kind}.h",
            next_event,
            *(["integrator/guide.h", guide.axis(lights)] if guided else []),
            f"integrator/scatter{'_guided' if guided else ''}.h",
        ),
    )


_MAJORANTS = {
    "global": """\
static inline real majorant_mean_free_path(const struct world *world) {
    return majorant_global_mean_free_path(&world->scene->majorant);
}
""",
    "grid": """\
static inline void majorant_start(const struct world *world, vector origin, vector along, real far,
                                  majorant_walk *walk, mask chosen) {
    majorant_grid_start(&world->scene->majorant, world->majorant_grid_bounds, origin, along, (real)0.f, far, walk,
                        chosen);
}
static inline mask majorant_step(const struct world *world, majorant_walk *walk, real depth) {
    return majorant_grid_step(&world->scene->majorant, world->majorant_grid_bounds, walk, depth, (mask)-1);
}
""",
}


def _dispatch(kinds: Kinds, grids: Buffers, lights: list[Record]) -> str:
    """The calls that the integrator makes, each to just the kinds that the scene uses."""
    (camera,), (volume,) = kinds["camera"], kinds["volume"]
    (phase,), (majorant,), (flight,) = (kinds[name] for name in ("phase", "majorant", "free_flight"))
    buffers = "".join(f"world->{name}, " for name in grids)
    escape = [light for light in lights if module("light", light.kind).ON_ESCAPE]
    sampled = [light for light in lights if light not in escape]
    radiance = "spectrum_grey((real)0.f)"
    for light in escape:
        call = f"light_{light.kind}_radiance(&world->scene->{light.member}, direction)"
        radiance = call if light is escape[0] else f"spectrum_add({radiance}, {call})"
    text = f"""\
static inline void camera_ray(const struct world *world, real u, real v, vector *anchor, vector *direction,
                              real *start) {{
    camera_{camera}_ray(&world->scene->camera, u, v, anchor, direction, start);
}}
static inline __constant const affine *volume_to_local(const struct world *world) {{
    return &world->scene->volume.to_local;
}}
static inline vector3 volume_size(const struct world *world) {{ return world->scene->volume.size; }}
static inline spectrum volume_albedo(const struct world *world) {{
    return spectrum_uniform(world->scene->volume.albedo);
}}
static inline real volume_density(const struct world *world, vector p, words w) {{
    return volume_{volume}_density(&world->scene->volume, {buffers}p, w);
}}
{_MAJORANTS[majorant]}\
static inline mask free_flight_collides(real density, real u) {{ return free_flight_{flight}_collides(density, u); }}
static inline vector phase_sample(const struct world *world, vector in, real u, real v) {{
    return phase_{phase}_sample(&world->scene->phase, in, u, v);
}}
static inline spectrum light_radiance(const struct world *world, vector direction) {{ return {radiance}; }}
"""
    if sampled:
        (transmittance,) = kinds["transmittance"]
        # Of cells no transmittance asks for one.
        free_path = "majorant_mean_free_path(world)" if majorant == "global" else "(real)0.f"
        text += f"""\
static inline real phase_eval(const struct world *world, vector in, vector out) {{
    return phase_{phase}_eval(&world->scene->phase, in, out);
}}
static inline mask transmittance_step(const struct world *world, real *value, real density, real length, mask escape,
                                      real u) {{
    return transmittance_{transmittance}_step(value, density, length, {free_path}, escape, u);
}}
{_light_sample(sampled)}"""
    return text


def _light_sample(lights: list[Record]) -> str:
    """One of the lights that must be sampled, each with the same probability."""
    lines = ["static inline vector light_sample(const struct world *world, real u, spectrum *weight) {"]
    for index, light in enumerate(lights):
        call = f"light_{light.kind}_sample(&world->scene->{light.member}, "
        if index == 0:
            lines.append(f"    vector towards = {call}weight);")
        else:
            lines += [
                "    spectrum other;" if index == 1 else "",
                f"    mask chosen_{index} = test(u >= {index / len(lights):.9g}f);",
                f"    towards = vector_pick(towards, {call}&other), chosen_{index});",
                f"    *weight = spectrum_pick(*weight, other, chosen_{index});",
            ]
    if len(lights) > 1:
        lines.append(f"    *weight = spectrum_scale(*weight, (real){len(lights)}.f);")
    return "\n".join([*filter(None, lines), "    return towards;", "}", ""])
