"""Single rays through media by the integrators without random numbers, and their oracles in float64.

A ray is six float32 numbers, origin and direction, one a pixel; positions are origin + t direction, for t from 0 on. The
oracles look grids up by scipy and integrate between all planes, by no code of ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.ndimage import map_coordinates

from woodcock import deterministic, layers
from woodcock.device import Context
from woodcock.film import Film
from woodcock.formats import Grid
from woodcock.layout import Layout, Record, module
from woodcock.program import OPTIONS
from woodcock.scene import BoxShape, SphereShape
from woodcock.space import Array, Space
from woodcock.volume import field

NONE = np.zeros(1)


@dataclass(frozen=True)
class Homogeneous:
    shape: BoxShape | SphereShape
    sigma: Any
    epsilon: Any = 0.0

    def interval(self, origin: Array, along: Array) -> tuple[float, float]:
        near, far = module("shape", self.shape.kind).interval(self.shape, origin[None], along[None])
        return (float(near[0]), float(far[0])) if near[0] < far[0] else (np.inf, -np.inf)

    def kinks(self, origin: Array, along: Array) -> list[float]:
        return []

    def at(self, p: Array) -> tuple[Array, Array]:
        shape = (len(p), np.size(self.sigma)), (len(p), np.size(self.epsilon))
        return np.broadcast_to(self.sigma, shape[0]), np.broadcast_to(self.epsilon, shape[1])


@dataclass(frozen=True)
class Gridded:
    """values: [z][y][x]; σ = sigma × value; ε = epsilon × value², which no rule for cubics is made for, or × value."""

    values: Any
    to_scene: Array
    sigma: Any = 1.0
    epsilon: Any = 0.0
    nearest: bool = False
    isothermal: bool = False

    def local(self, origin: Array, along: Array) -> tuple[Array, Array]:
        matrix = np.linalg.inv(self.to_scene)
        return origin @ matrix[:3, :3].T + matrix[:3, 3], along @ matrix[:3, :3].T

    def interval(self, origin: Array, along: Array) -> tuple[float, float]:
        o, d = self.local(origin, along)
        near, far = 0.0, np.inf
        for o_axis, d_axis, n in zip(o, d, self.values.shape[::-1], strict=True):
            if d_axis == 0:
                if not 0 <= o_axis <= n:
                    return np.inf, -np.inf
                continue
            a, b = sorted([-o_axis / d_axis, (n - o_axis) / d_axis])
            near, far = max(near, a), min(far, b)
        return (near, far) if near < far else (np.inf, -np.inf)

    def kinks(self, origin: Array, along: Array) -> list[float]:
        o, d = self.local(origin, along)
        found: list[float] = []
        for o_axis, d_axis, n in zip(o, d, self.values.shape[::-1], strict=True):
            if d_axis != 0:
                found += ((np.arange(n) + (0 if self.nearest else 0.5) - o_axis) / d_axis).tolist()
        return found

    def at(self, p: Array) -> tuple[Array, Array]:
        local, _ = self.local(p, p)
        order, index = (0, np.floor(local)) if self.nearest else (1, local - 0.5)
        value = map_coordinates(np.asarray(self.values, float), index.T[::-1], order=order, mode="nearest")[:, None]
        return value * np.atleast_1d(self.sigma), (value if self.isothermal else value**2) * np.atleast_1d(self.epsilon)


Media = list[Homogeneous | Gridded]

# Oracles


def pieces(media: Media, ray: Array) -> tuple[Array, list[tuple[float, float]]]:
    """Where the coefficients along a ray may have kinks or jumps, and the media's intervals."""
    origin, along = ray[:3].astype(float), ray[3:].astype(float)
    spans = [medium.interval(origin, along) for medium in media]
    ends = [max(t, 0.0) for span in spans if span[0] < span[1] for t in span]
    kinks = [t for medium in media for t in medium.kinks(origin, along)]
    if not ends:
        return np.zeros(0), spans
    inside = [t for t in kinks if min(ends) < t < max(ends)]
    return np.unique([*ends, *inside]), spans


def coefficients(media: Media, ray: Array, spans: list[tuple[float, float]], a: float, b: float, t: Array) -> Any:
    """σ and ε, (n, 1 or 3), at t within the piece [a, b]."""
    p, middle = ray[:3].astype(float) + t[:, None] * ray[3:].astype(float), (a + b) / 2
    sigma, epsilon = np.zeros((len(t), 1)), np.zeros((len(t), 1))
    for medium, (near, far) in zip(media, spans, strict=True):
        if near < middle < far:
            own = medium.at(p)
            sigma, epsilon = sigma + own[0], epsilon + own[1]
    return sigma, epsilon


def optical_depth(media: Media, ray: Array) -> Array:
    """(1,) or (3,), by Gauss–Legendre of seven points on either half of each piece."""
    bounds, spans = pieces(media, ray)
    x, w = np.polynomial.legendre.leggauss(7)
    total = NONE
    for a, b in zip(bounds[:-1], bounds[1:], strict=True):
        for low, high in ((a, (a + b) / 2), ((a + b) / 2, b)):
            sigma, _ = coefficients(media, ray, spans, a, b, low + (high - low) * (x + 1) / 2)
            total = total + (high - low) / 2 * (w @ sigma)
    return total


def emitted(media: Media, ray: Array, behind: float = 0.0) -> float:
    """Grey radiance that reaches the ray's origin, to about 1e-8: scipy's Radau on L′ + σ L = ε towards the camera, from
    the far end or from where an optical depth of 40 hides the rest."""
    bounds, spans = pieces(media, ray)
    radiance, depth, last = np.array([behind]), 0.0, 0
    for last, (a, b) in enumerate(zip(bounds[:-1], bounds[1:], strict=True)):
        if depth > 40:
            break
        depth += (b - a) * float(coefficients(media, ray, spans, a, b, np.linspace(a, b, 9)[1:-1])[0].mean())
    for index in range(min(last, len(bounds) - 2), -1, -1):
        a, b = bounds[index], bounds[index + 1]

        def slope(s: float, y: Array, a: float = a, b: float = b) -> Array:
            sigma, epsilon = coefficients(media, ray, spans, a, b, np.array([b - s]))
            return np.asarray(epsilon[0] - sigma[0] * y)

        scale = max(float(radiance[0]), 1e-30)
        radiance = solve_ivp(slope, (0, b - a), radiance, "Radau", rtol=1e-9, atol=scale * 1e-10).y[:, -1]
    return float(radiance[0])


# Device


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
    lanes, pixels = deterministic.lanes_of(lanes, precise=precise), size[0] * size[1]
    kernel = context.build(deterministic.compose(layout, lanes, precise=precise).text, OPTIONS, "render")
    items = -(-pixels // lanes)
    sums = np.zeros((layout.channels, 4, items * lanes), np.float32)
    faults = np.zeros((2, items * lanes), np.uint32)
    outputs = [context.output(array) for array in (sums, faults)]
    arrays = [array if isinstance(array, np.ndarray) else array.array() for array in layout.buffers.values()]
    inputs = [context.upload(array) for array in (deterministic.pack(layout, precise=precise), *arrays)]
    first, stop = samples
    kernel(context.queue, (items,), None, *inputs, *outputs, np.uint32(first), np.uint32(stop - first))
    for array, buffer in zip((sums, faults), outputs, strict=True):
        context.download(array, buffer)
    exponents = np.array(layers.exponents(layout.names, layout.space.radiance_exponent, layout.space.length_exponent))
    return deterministic.film(sums, samples, size, layout.names, exponents, int(faults[0, :pixels].sum()))


def _layout(
    integrator: str, media: Media, rays: Any, tolerance: float, radiance: Any, channels: int, grey: bool
) -> Layout:
    colour = {"sigma": "float" if grey else "colour", "epsilon": "colour"}
    records = [
        Record("film", "", "film", {"width": "int", "height": "int", "seed": "uint"}, {"width": len(rays), "height": 1, "seed": 0}),
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
            records.append(Record("shape", medium.shape.kind, f"shape_{index}", kind.FIELDS, kind.record(medium.shape, Space())))
            shape = f"world->scene->shape_{index}"
            described.append(deterministic.Medium(f"{shape}.to_local", shape=(medium.shape.kind, shape), emits=emits))
            text += _homogeneous(index, grey)
        else:
            stored = field.Field(Grid("density", np.asarray(medium.values, np.float32), np.eye(4), placed=False), float(np.max(medium.values)), "float", 1.0, 0.0)
            numbers = stored.record(np.eye(4), medium.to_scene)
            records.append(Record("volume_field", "", f"field_{index}", field.FIELDS, numbers))
            buffers[f"values_{index}"] = np.concatenate([chunk.array() for chunk in stored.chunks(40)])
            lattice = deterministic.Lattice(f"field_{index}", medium.nearest)
            described.append(deterministic.Medium("world->scene->device.to_local", lattices=(lattice,), emits=emits))
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
        before_world=(*deterministic.files(described, grey=grey), *files),
        after_world=(
            PLACES.format(sides=sides),
            deterministic.radiance(["light_constant_radiance(&world->scene->light, direction)"]),
            text,
            deterministic.walks(described, emission=integrator == "emission_absorption"),
        ),
    )


#: In place of `deterministic.camera`: the ray of a pixel, whatever the sample.
PLACES = """\
#define MEDIA_ROUNDINGS (16.f + 4.f * {sides}.f)
#define SEQUENCE_0 3242174889u
#define SEQUENCE_1 2447445414u
static inline real filter_offset(const struct world *world, real u) {{ return filter_box_offset(&world->scene->filter, u); }}
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
    scaled = "value * world->scene->medium_{0}.sigma" if grey else "spectrum_scale(spectrum_uniform(world->scene->medium_{0}.sigma), value)"
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
    return f"""\
static inline real medium_{index}_value(const struct world *world, vector p) {{
    vector q = affine_point(&world->scene->field_{index}.from_local, p);{look_up}
}}
static inline coefficient medium_{index}_sigma_t_exact(const struct world *world, vector p) {{
    real value = medium_{index}_value(world, p);
    return {scaled.format(index)};
}}
static inline spectrum medium_{index}_emission(const struct world *world, vector p) {{
    real value = medium_{index}_value(world, p);
    return spectrum_scale(spectrum_uniform(world->scene->medium_{index}.epsilon), {"value" if medium.isothermal else "value * value"});
}}
"""
