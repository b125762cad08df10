"""The loop's parts: each in the form that a scene needs, in the order in which they build on each other."""

from __future__ import annotations

from dataclasses import dataclass

from woodcock.integrator import guide
from woodcock.integrator.full import lights, media
from woodcock.layers import SUFFIXES, order_layers
from woodcock.layout import Record, module
from woodcock.scene import ConstantVolume, GridVolume, LayerName, Scene, Volume

#: The film has a plane for every sum.
PLANES = "#define PLANES (CHANNELS + LAYERS)\n#define PLANE(c) (c)\n"


@dataclass(frozen=True)
class Uses:
    """What a scene uses. spectral: σ_t has colour somewhere; lights: their records; shining: surfaces do."""

    scene: Scene
    volumes: tuple[Volume, ...]
    channels: int
    lights: tuple[Record, ...]
    spectral: bool
    surfaces: bool
    shining: bool

    @property
    def grids(self) -> bool:
        return any(isinstance(volume, GridVolume) for volume in self.volumes)

    @property
    def constants(self) -> bool:
        return any(isinstance(volume, ConstantVolume) for volume in self.volumes)

    @property
    def emits(self) -> bool:
        return any(volume.emission is not None for volume in self.volumes)

    @property
    def layers(self) -> bool:
        return bool(self.scene.layers) or self.scene.orders is not None

    @property
    def sampled(self) -> list[Record]:
        return [light for light in self.lights if module("light", light.kind).SAMPLED]

    @property
    def next_event(self) -> bool:
        return bool(self.sampled) or self.shining

    @property
    def equiangular(self) -> bool:
        """Flights through grids have no transmittance in closed form to sample by."""
        local = any(module("light", light.kind).LOCAL for light in self.sampled)
        return local and self.constants and not self.grids

    @property
    def walks(self) -> bool:
        """Does anything ask for the transmittance along a ray?"""
        return self.next_event or not {"transmittance", "optical_depth"}.isdisjoint(self.scene.layers)

    @property
    def open(self) -> bool:
        """Is all that lies between a vertex and a light constant media and surfaces that let nothing pass?"""
        passing = any(surface.material.kind == "null" for surface in self.scene.surfaces)
        meshes = any(isinstance(volume, ConstantVolume) and volume.shape.kind == "mesh" for volume in self.volumes)
        return not (self.grids or self.layers or passing or meshes)

    @property
    def guided(self) -> bool:
        """Are some of the directions in which media scatter towards lights?"""
        return guide.guides(self.volumes, [light.kind for light in self.lights])

    @property
    def free_flight(self) -> str:
        """Through grids."""
        return self.scene.free_flight.kind if self.scene.free_flight and self.grids else "delta"

    @property
    def transmittance(self) -> str:
        """Through grids."""
        return self.scene.transmittance.kind if self.scene.transmittance and self.grids and self.walks else "ratio"

    @property
    def control(self) -> bool:
        """Does either know a lower bound on σ_t?"""
        return self.free_flight == "decomposition" or self.transmittance == "residual_ratio"

    @property
    def found_by_both(self) -> bool:
        """Is there a light that next-event estimation and scattering both find?"""
        return self.shining or any(module("light", light.kind).ON_ESCAPE for light in self.sampled)


def of(uses: Uses, *, dense_glow: bool) -> list[str]:
    """Parts for `flatten`, to follow the calls of media, phase functions and surfaces.

    dense_glow: do all media that emit do so where tentative collisions are dense?
    """
    guided = "_guided" if uses.guided else ""
    return [
        _camera(uses.scene),
        _layers(uses) + f"#define LEAST {'(-MAXFLOAT)' if uses.transmittance == 'ray_marching' else '0.f'}\n",
        "integrator/full/state.h",
        media.clocks(uses.volumes) if uses.constants else media.no_clocks(),
        f"integrator/full/{'spectral_mis' if uses.spectral else 'grey'}.h",
        "integrator/full/walk.h",
        _form("layers", uses.layers),
        media.albedo(uses.volumes),
        *_emission(uses, dense_glow=dense_glow),
        *(_grids(uses) if uses.grids else ["integrator/full/no_grids.h"]),
        lights.escape(uses.lights, len(uses.sampled) + uses.shining),
        *(["integrator/guide.h", guide.axis(uses.lights, "vector from, ")] if uses.guided else []),
        f"integrator/full/scatter{guided}.h",
        _scatter_pdf(uses.found_by_both),
        *([lights.choose(uses.lights, uses.shining)] if uses.next_event else []),
        *([lights.surface_pdf(uses.shining)] if uses.surfaces else []),
        *([f"integrator/full/surface_scatter{guided}.h"] if uses.surfaces else []),
        _form("surfaces", uses.surfaces),
        *([f"integrator/full/shadows_{'exact' if uses.open else 'walked'}.h"] if uses.next_event else []),
        *([lights.places(uses.lights), media.spans(uses.volumes)] if uses.equiangular else []),
        _form("equiangular", uses.equiangular),
        _form("next_event", uses.next_event),
    ]


def _grids(uses: Uses) -> list[str]:
    """Tracking through grids: delta and ratio tracking share a file, all others are put together."""
    assert uses.scene.majorant, "the plan settles it"
    majorant, flight, transmittance = uses.scene.majorant.kind, uses.free_flight, uses.transmittance
    calls = media.grids(uses.volumes, majorant, "world->majorant_grid_bounds, " if majorant == "grid" else "")
    if (flight, transmittance) == ("delta", "ratio"):
        return [calls, "integrator/full/grids.h"]
    parts = [calls]
    if uses.control:
        parts.append("integrator/full/control.h")
    if flight == "decomposition":
        parts.append(media.decomposed(uses.volumes))
    if transmittance == "residual_ratio":
        parts += [media.controls(uses.volumes), f"majorant/{majorant}_control.h"]
    if transmittance == "ray_marching":
        parts.append(f"majorant/{majorant}_ahead.h")
    forms = (f"flights_{flight}", f"walks_{transmittance}", "grids_by_kind")
    return parts + [f"integrator/full/{form}.h" for form in forms]


def _emission(uses: Uses, *, dense_glow: bool) -> list[str]:
    if not uses.emits:
        return ["integrator/full/no_emission.h"]
    form = "at_events" if dense_glow else "along"
    calls = media.emission(uses.volumes, tentative=dense_glow)
    return ["integrator/full/emission_shares.h", calls, f"integrator/full/emission_{form}.h"]


def _form(part: str, used: bool) -> str:
    return f"integrator/full/{'' if used else 'no_'}{part}.h"


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


def _layers(uses: Uses) -> str:
    """The state of the layers beside the beauty, and at which channel after it each begins."""
    scene, channels = uses.scene, uses.channels
    if not uses.layers:
        return f"{PLANES}enum {{ LAYERS = 0 }};\ntypedef struct {{ int unused; }} layer_values;\n"
    orders = len(order_layers(scene))
    start = orders * channels
    at: dict[LayerName, int] = {}
    for layer in scene.layers:
        at[layer] = start
        start += len(SUFFIXES[layer]) or channels
    constants = [f"LAYERS = {start}", f"ORDERS = {orders}"]
    constants += [f"{layer.upper()} = {at.get(layer, -1)}" for layer in SUFFIXES]
    return f"""\
{PLANES}enum {{ {", ".join(constants)} }};
typedef struct {{
    real value[LAYERS], lead; // lead: from the camera to the segment at which the path began
    vector start;
    mask unmet, probing;      // nothing met yet; a walk along the camera ray
}} layer_values;
"""


def _scatter_pdf(found_by_both: bool) -> str:
    value = "path_scatter_pdf(p, world, out)" if found_by_both else "(real)1e30f"
    return f"""\
static inline real scatter_pdf(const path *p, const struct world *world, vector out) {{ return {value}; }}
"""
