"""Where paths begin and where they end: any camera, any filter, any layers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from woodcock.generic.slots import kinds, single
from woodcock.integrator.volumetric_path_full import frame
from woodcock.layers import SUFFIXES, order_layers
from woodcock.layout import Record, module
from woodcock.scene import Camera, Filter, Scene
from woodcock.space import Space

CAMERAS, FILTERS = kinds(Camera), kinds(Filter)
#: Which camera and which filter.
VIEW = {"camera": "int", "filter": "int"}
#: Planes of the film, layers of orders, and where each other layer begins, or -1.
LAYERS: dict[str, str] = {"planes": "int", "orders": "int", **dict.fromkeys(map(str, SUFFIXES), "int")}
#: Sums beside the beauty's: orders 0 to 3, the rest, and every other layer, all in three channels.
ROOM = 27


@dataclass(frozen=True)
class View:
    """sums: which of the kernel's sums goes into each plane of the film."""

    records: tuple[Record, ...]
    sums: NDArray[np.int32]
    text: str


def view(scene: Scene, space: Space, channels: int) -> View:
    """channels: of the film; the kernel's spectra have three."""
    film, camera, filter_ = frame(scene, space)
    chosen = {"camera": CAMERAS.index(camera.kind), "filter": FILTERS.index(filter_.kind)}
    records = [film, Record("view", "", "view", VIEW, chosen)]
    for own, names in ((camera, CAMERAS), (filter_, FILTERS)):
        for name in names:
            fields = module(own.concept, name).FIELDS
            values = own.values if name == own.kind else None
            records.append(single(own.concept, name, f"{own.concept}_{name}", fields, values))
    at, sums, used = _layers(scene, channels)
    records.append(Record("layers", "", "layers", LAYERS, {"planes": len(sums), **at}))
    return View(tuple(records), np.array(sums, np.int32), _text(max(ROOM, used)))


def _layers(scene: Scene, channels: int) -> tuple[dict[str, int], list[int], int]:
    """Where layers begin after the beauty, the sum of every plane, and how many the layers take."""
    orders = len(order_layers(scene))
    at: dict[str, int] = {"orders": orders, **dict.fromkeys(SUFFIXES, -1)}
    sums = [3 * k + c for k in range(1 + orders) for c in range(channels)]
    start = 3 * orders
    for layer in scene.layers:
        at[layer] = start
        sums += [3 + start + c for c in range(len(SUFFIXES[layer]) or channels)]
        start += len(SUFFIXES[layer]) or 3
    return at, sums, start


def _text(room: int) -> str:
    rays, offsets = [], []
    for number, camera in enumerate(CAMERAS):
        lens = "lens_u, lens_v, " if getattr(module("camera", camera), "LENS", False) else ""
        arguments = f"&world->scene->camera_{camera}, u, v, {lens}anchor, direction, start"
        rays.append(f"    if (world->scene->view.camera == {number}) camera_{camera}_ray({arguments});\n")
    for number, filter_ in enumerate(FILTERS):
        call = f"filter_{filter_}_offset(&world->scene->filter_{filter_}, u)"
        offsets.append(f"    if (world->scene->view.filter == {number}) offset = {call};\n")
    return f"""\
static inline void camera_ray(const struct world *world, real u, real v, real lens_u, real lens_v, vector *anchor,
                              vector *direction, real *start) {{
{"".join(rays)}}}
static inline real filter_offset(const struct world *world, real u) {{
    real offset = (real)0.f;
{"".join(offsets)}    return offset;
}}
#define PLANES ((int)world->scene->layers.planes)
#define LEAST 0.f
#define PLANE(c) (world->film_sums[c])
enum {{ LAYERS = {room} }};
typedef struct {{
    real value[LAYERS], lead; // lead: from the camera to the segment at which the path began
    vector start;
    mask unmet, probing;      // nothing met yet; a walk along the camera ray
    __constant const struct layers *at;
}} layer_values;
"""
