"""Single rays through media by the integrators without random numbers: one ray of ray_oracles.py a pixel."""

from __future__ import annotations

from typing import Any

import numpy as np
from tests.kernels.ray_oracles import Gridded, Homogeneous, Media

from woodcock import deterministic, layers
from woodcock.device import Context
from woodcock.faults import audited
from woodcock.film import Film
from woodcock.formats import Grid
from woodcock.integrator import deterministic_text
from woodcock.launch import Launcher
from woodcock.layout import Layout, Record, module
from woodcock.program import compose
from woodcock.space import Space
from woodcock.volume import field


def trace(
    context: Context,
    integrator: str,
    media: Media,
    rays: Any,
    *,
    lanes: int,
    precise: bool = True,
    tolerance: float = 1e-4,
    radiance: Any = 1.0,
    samples: tuple[int, int] = (0, 1),
) -> Film:
    """A film of (1, rays). precise: in doubles."""
    spectra = [radiance, *(x for medium in media for x in (medium.sigma, medium.epsilon))]
    channels = max(np.size(spectrum) for spectrum in spectra)
    grey = all(np.size(medium.sigma) == 1 for medium in media)
    layout = _layout(integrator, media, np.asarray(rays, np.float32), tolerance, radiance, channels, grey)
    return launch(context, layout, (1, len(rays)), lanes=lanes, precise=precise, samples=samples)


def launch(
    context: Context, layout: Layout, size: tuple[int, int], *, lanes: int, precise: bool, samples: tuple[int, int]
) -> Film:
    """The samples of a layout's film of (height, width)."""
    lanes = deterministic.lanes_of(lanes, precise=precise)
    launcher = Launcher(context, compose(layout, lanes, precise=precise), layout.channels, {})
    launcher.upload({"scene": layout.pack(precise=precise), **layout.buffers})
    first, stop = samples
    sums, planes = launcher.run(size[0] * size[1], first, stop - first)
    exponents = np.array(layers.exponents(layout.names, layout.space.radiance_exponent, layout.space.length_exponent))
    return deterministic.film(sums, samples, size, layout.names, exponents, audited(planes)[0])


def _layout(
    integrator: str, media: Media, rays: Any, tolerance: float, radiance: Any, channels: int, grey: bool
) -> Layout:
    colour = {"sigma": "float" if grey else "colour", "epsilon": "colour"}
    records = [
        Record(
            "film",
            "",
            "film",
            {"width": "int", "height": "int", "seed": "uint"},
            {"width": len(rays), "height": 1, "seed": 0},
        ),
        Record("filter", "box", "filter", {"radius": "float"}, {"radius": 0.5}),
        Record("integrator", integrator, "integrator", {"tolerance": "float"}, {"tolerance": tolerance}),
        Record("camera", "rays", "camera", {"count": "int"}, {"count": len(rays)}),
        Record("light", "constant", "light", {"radiance": "colour"}, {"radiance": radiance}),
        Record("device", "", "device", {"to_local": "affine"}, {"to_local": np.eye(4)[:3]}),
    ]
    buffers: dict[str, Any] = {"rays": np.pad(rays, ((0, 16), (0, 0)), mode="edge").reshape(-1)}
    files = ["filter/box.h", "light/constant.h", "core/gather.h"]
    files += ["volume/field.h"] if any(isinstance(medium, Gridded) for medium in media) else []
    described, text, sides = [], "", 0
    for index, medium in enumerate(media):
        values = {"sigma": medium.sigma, "epsilon": medium.epsilon}
        records.append(Record("medium", "", f"medium_{index}", colour, values))
        emits = bool(np.any(np.asarray(medium.epsilon) > 0))
        if isinstance(medium, Homogeneous):
            kind = module("shape", medium.shape.kind)
            records.append(
                Record("shape", medium.shape.kind, f"shape_{index}", kind.FIELDS, kind.record(medium.shape, Space()))
            )
            shape = f"world->scene->shape_{index}"
            described.append(
                deterministic_text.Medium(f"{shape}.to_local", shape=(medium.shape.kind, shape), emits=emits)
            )
            text += _homogeneous(index, grey)
        else:
            stored = field.Field(
                Grid("density", np.asarray(medium.values, np.float32), np.eye(4), placed=False),
                float(np.max(medium.values)),
                "float",
                1.0,
                0.0,
            )
            numbers = stored.record(np.eye(4), medium.to_scene)
            records.append(Record("volume_field", "", f"field_{index}", field.FIELDS, numbers))
            buffers[f"values_{index}"] = np.concatenate([chunk.array() for chunk in stored.chunks(40)])
            lattice = deterministic_text.Lattice(f"field_{index}", medium.nearest)
            described.append(
                deterministic_text.Medium("world->scene->device.to_local", lattices=(lattice,), emits=emits)
            )
            text += _gridded(index, medium, grey)
            sides = max(sides, *medium.values.shape)
    return Layout(
        integrator=integrator,
        kinds={},
        channels=channels,
        names=("R", "G", "B")[:channels] if channels == 3 else ("Y",),
        records=tuple(records),
        buffers=buffers,
        space=Space(),
        before_world=(*deterministic_text.files(described, grey=grey), *files),
        after_world=(
            PLACES.format(sides=sides),
            deterministic_text.radiance(["light_constant_radiance(&world->scene->light, direction)"]),
            text,
            deterministic_text.walks(described, emission=integrator == "emission_absorption"),
        ),
    )


#: In place of `deterministic_text.camera`: the ray of a pixel, whatever the sample.
PLACES = """\
#define MEDIA_ROUNDINGS (16.f + 4.f * {sides}.f)
static inline real filter_offset(const struct world *world, real u) {{
    return filter_box_offset(&world->scene->filter, u);
}}
static inline void camera_ray(const struct world *world, real u, real v, uint sample, vector *anchor,
                              vector *direction, real *near) {{
    integer at = to_integer(u * world->scene->camera.count) * 6;
    *anchor = vector_gather(world->rays, at);
    *direction = vector_gather(world->rays, at + 3);
    *near = (real)0.f;
}}
"""


def _homogeneous(index: int, grey: bool) -> str:
    uniform = "(real)" if grey else "spectrum_uniform"
    return f"""\
static inline coefficient medium_{index}_sigma_t_exact(const struct world *world, vector p) {{
    return {uniform}(world->scene->medium_{index}.sigma);
}}
static inline spectrum medium_{index}_emission(const struct world *world, vector p) {{
    return spectrum_uniform(world->scene->medium_{index}.epsilon);
}}
"""


def _gridded(index: int, medium: Gridded, grey: bool) -> str:
    field = f"&world->scene->field_{index}"
    scaled = (
        "value * world->scene->medium_{0}.sigma"
        if grey
        else "spectrum_scale(spectrum_uniform(world->scene->medium_{0}.sigma), value)"
    )
    look_up = f"""
    field_cell cell = field_cell_of({field}, q);
    real value = (real)0.f;
    for (int corner = 0; corner < 8; ++corner) {{
        field_place at = field_corner({field}, &cell, corner);
        value += field_weight(&cell, corner) * gather(float, world->values_{index}, (at.brick << 6) | at.voxel);
    }}
    return value;"""
    if medium.nearest:
        look_up = f"""
    field_place at = field_nearest({field}, q);
    return gather(float, world->values_{index}, (at.brick << 6) | at.voxel);"""
    power = "value" if medium.isothermal else "value * value"
    return f"""\
static inline real medium_{index}_value(const struct world *world, vector p) {{
    vector q = affine_point(&world->scene->field_{index}.from_local, p);{look_up}
}}
static inline coefficient medium_{index}_sigma_t_exact(const struct world *world, vector p) {{
    real value = medium_{index}_value(world, p);
    return {scaled.format(index)};
}}
static inline coefficient medium_{index}_sigma_t_pair(const struct world *world, vector p, vector q) {{
    return coefficient_add(medium_{index}_sigma_t_exact(world, p), medium_{index}_sigma_t_exact(world, q));
}}
static inline spectrum medium_{index}_emission(const struct world *world, vector p) {{
    real value = medium_{index}_value(world, p);
    return spectrum_scale(spectrum_uniform(world->scene->medium_{index}.epsilon), {power});
}}
"""
