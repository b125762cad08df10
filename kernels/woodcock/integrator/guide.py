"""Guides scattered directions towards lights that next-event estimation alone finds (guide.h): numbers and axes."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from woodcock.layout import Record, module
from woodcock.phase.henyey_greenstein import lobe
from woodcock.scene import Volume

FIELDS = {"g": "float", "gap": "float", "share": "float", "surface_share": "float", "settle": "float"}
#: What a light's record tells of where it is: a direction, or a place.
AXES = {"directional": "towards", "sun": "towards", "point": "position", "spot": "position"}
#: Phase functions that favour no direction, whose product with another one is that one.
EVEN = ("isotropic", "rayleigh")
#: The share of the first scattering is this × (1 - |g|), over 1 in thin media and over OPAQUE in opaque ones; surfaces,
#: whose lobes are wide, have this, and a half at most.
SHARE, OPAQUE = 1.5, 10.0


def guides(volumes: Sequence[Volume], lights: Collection[str]) -> bool:
    """Is there anything to guide? lights: their kinds."""
    return not AXES.keys().isdisjoint(lights) and any(volume.phase.kind not in EVEN for volume in volumes)


def record(volumes: Sequence[Volume], lights: Collection[str], depth: float) -> Record:
    """lights: their kinds; depth: the largest σ_t times the scene's size. With nothing to guide, the share is 0."""
    means = [module("phase", volume.phase.kind).mean_cosine(volume.phase) for volume in volumes]
    g = float(max(means, key=abs, default=0.0))
    share = SHARE * (1 - abs(g)) if guides(volumes, lights) else 0.0
    if any(AXES.get(kind) == "position" for kind in lights):
        # A flight also gathers by 1 / its distance from a point of light.
        g = math.copysign((2 + abs(g)) / 3, g)
    # A thin medium of a phase function that is nearly even could have a share above 1.
    settle = max(min(1 + depth / 2, OPAQUE), 2 * share)
    surface = min(SHARE, settle / 2) if share > 0 else 0.0
    return Record("guide", "", "guide", FIELDS, dict(zip(FIELDS, (*lobe(g), share, surface, settle), strict=True)))


def axis(lights: Sequence[Record], place: str = "") -> str:
    """Lights take turns by the number of scatterings. place: the vertex, where lights have one."""
    found = [light for light in lights if light.kind in AXES]
    lines = []
    for index, light in enumerate(found):
        value = f"vector_uniform(world->scene->{light.member}.{AXES[light.kind]})"
        if AXES[light.kind] == "position":
            value = f"guide_towards({value}, from)"
        if index == 0:
            lines.append(f"    vector axis = {value};\n")
        else:
            lines.append(f"    axis = vector_pick(axis, {value}, test(order % {len(found)} == {index}));\n")
    return f"""\
static inline vector guide_axis(const struct world *world, {place}integer order) {{
{"".join(lines)}    return axis;
}}
"""
