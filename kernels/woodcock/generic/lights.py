"""Any lights: those of each kind in an array, and the chance of each that must be sampled as an uploaded number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from woodcock.generic.slots import array, kinds
from woodcock.integrator.guide import AXES
from woodcock.layout import Record, element, instances, module
from woodcock.light.image import Picture
from woodcock.scene import Light
from woodcock.space import Space

KINDS = kinds(Light)
SAMPLED = tuple(kind for kind in KINDS if module("light", kind).SAMPLED)
LOCAL = tuple(kind for kind in KINDS if module("light", kind).LOCAL)
#: Lights of each kind, and of all that are sampled, the surfaces that shine being one of them; chance: of each; places:
#: of points of light that flights are to have vertices for; both: does scattering find any light that is sampled?
LIGHTS = {
    **{f"{kind}s": "int" for kind in KINDS},
    "sampled": "int",
    "shines": "int",
    "chance": "float",
    "places": "int",
    "place_chance": "float",
    "both": "int",
}
#: Lights of a kind.
ROOM = 16
TYPES = {"float": np.float32, "uint": np.uint32, "int": np.int32}


def lights(
    shining: Sequence[Light | Picture], space: Space, *, surfaces: bool, equiangular: bool
) -> tuple[list[Record], dict[str, NDArray[np.generic]]]:
    """surfaces: do any shine; equiangular: are flights towards points of light to have a second vertex?"""
    records, found = instances("light", ((f"light_{i}", light) for i, light in enumerate(shining)), space)
    of_kind: dict[str, list[Mapping[str, Any]]] = {kind: [] for kind in KINDS}
    for record in records:
        of_kind[record.kind].append(record.values)
    sampled = sum(len(of_kind[kind]) for kind in SAMPLED) + surfaces
    places = sum(len(of_kind[kind]) for kind in LOCAL) if equiangular else 0
    both = surfaces or any(of_kind[kind] for kind in SAMPLED if module("light", kind).ON_ESCAPE)
    values = {
        **{f"{kind}s": len(of_kind[kind]) for kind in KINDS},
        "sampled": sampled,
        "shines": int(surfaces),
        "chance": 1 / sampled if sampled else 0.0,
        "places": places,
        "place_chance": 1 / places if places else 0.0,
        "both": int(both),
    }
    arrays = (
        array("light", kind, f"light_{kind}", module("light", kind).FIELDS, of_kind[kind], ROOM) for kind in KINDS
    )
    buffers = {
        name: found.get(name, np.zeros(1, TYPES[ctype]))
        for kind in KINDS
        for part, ctype in getattr(module("light", kind), "BUFFERS", {}).items()
        for name in (f"light_{kind}_{part}",)
    }
    assert all(element(array) in TYPES for array in buffers.values())
    return [Record("lights", "", "lights", LIGHTS, values), *arrays], buffers


def _call(kind: str, verb: str, arguments: str) -> str:
    names = getattr(module("light", kind), "BUFFERS", ())
    buffers = "".join(f"world->light_{kind}_{name}, " for name in names)
    return f"light_{kind}_{verb}(&world->scene->light_{kind}[i], {buffers}{arguments})"


def _sample(kind: str) -> str:
    if kind == "directional":
        towards = _call(kind, "sample", "&other.weight")
        return f"other.towards = {towards}, other.distance = (real)1e30f, other.pdf = (real)0.f;"
    return _call(kind, "sample", "from, v, w, &other") + ";"


def _each(kind: str, body: str) -> str:
    return f"    for (int i = 0; i < world->scene->lights.{kind}s; ++i) {{\n{body}    }}\n"


def text() -> str:
    """What a path finds on escape, and one light chosen for next-event estimation."""
    escape = ""
    for kind in KINDS:
        if not module("light", kind).ON_ESCAPE:
            continue
        found = _call(kind, "radiance", "direction")
        if kind in SAMPLED:
            found = f"spectrum_scale({found}, pdf / (pdf + {_call(kind, 'pdf', 'direction')} * LIGHT_CHANCE))"
        escape += _each(kind, f"        sum = spectrum_add(sum, {found});\n")
    choices, where, spans, samples = "", "", "", ""
    for kind in SAMPLED:
        place = "        place = pick(place, (integer)points++, chosen & locally);\n"
        choices += _each(
            kind,
            f"""\
        chosen = test(light == at++);
        if (some(chosen)) {{
            {_sample(kind)}
            light_take(s, &other, chosen);
        }}
{place if kind in LOCAL else ""}""",
        )
    axes = ""
    for kind, member in AXES.items():
        axis = f"vector_uniform(world->scene->light_{kind}[i].{member})"
        axis = f"guide_towards({axis}, from)" if member == "position" else axis
        axes += _each(kind, f"        axis = vector_pick(axis, {axis}, test(turn == at++));\n")
    guided = " + ".join(f"world->scene->lights.{kind}s" for kind in AXES)
    for kind in LOCAL:
        position = f"vector_uniform(world->scene->light_{kind}[i].position)"
        where += _each(kind, f"        place = vector_pick(place, {position}, test(light == at++));\n")
        if module("light", kind).SPANS:
            spans += _each(
                kind,
                f"""\
        low = *near, high = *far;
        light_{kind}_span(&world->scene->light_{kind}[i], origin, direction, &low, &high);
        chosen = test(light == at++);
        *near = pick(*near, low, chosen);
        *far = pick(*far, high, chosen);
""",
            )
        else:
            spans += _each(kind, "        ++at;\n")
        samples += _each(kind, f"        {_sample(kind)}\n        light_take(s, &other, test(light == at++));\n")
    return _TEXT.format(
        axes=axes, guided=guided, escape=escape, choices=choices, where=where, spans=spans, samples=samples
    )


_TEXT = """\
#define LIGHT_CHANCE ((real)world->scene->lights.chance)
#define PLACE_CHANCE ((real)world->scene->lights.place_chance)
static inline spectrum light_escape(const struct world *world, vector direction, real pdf) {{
    spectrum sum = spectrum_grey((real)0.f);
{escape}    return sum;
}}
// The lights take turns.
static inline vector guide_axis(const struct world *world, vector from, integer order) {{
    vector axis = vector_of((real)0.f, (real)0.f, (real)1.f);
    const int count = {guided};
    int at = 0;
    if (!count) return axis;
    const integer turn = order % count;
{axes}    return axis;
}}
static inline void light_take(light_sample *s, const light_sample *other, mask chosen) {{
    s->towards = vector_pick(s->towards, other->towards, chosen);
    s->distance = pick(s->distance, other->distance, chosen);
    s->weight = spectrum_pick(s->weight, other->weight, chosen);
    s->pdf = pick(s->pdf, other->pdf, chosen);
}}
// The light's index among points of light that flights have vertices for, or -1.
static inline integer light_choose(const struct world *world, vector from, real u, real v, real w, light_sample *s) {{
    const int count = world->scene->lights.sampled;
    const mask locally = test((integer)(int)world->scene->lights.places > 0);
    const integer light = clamp_index(to_integer(u * (float)count), count);
    integer place = (integer)-1;
    int at = 0, points = 0;
    light_sample other;
    mask chosen;
    s->towards = from, s->distance = s->pdf = (real)0.f, s->weight = spectrum_grey((real)0.f);
{choices}    chosen = test(light == at);
    if (world->scene->lights.shines && some(chosen)) {{
        surface_light_sample(world, from, u * (float)count - (float)(count - 1), v, w, &other);
        light_take(s, &other, chosen);
    }}
    s->weight = spectrum_scale(s->weight, (real)(float)count);
    s->pdf *= LIGHT_CHANCE;
    return place;
}}
static inline vector light_place(const struct world *world, integer light) {{
    vector place = vector_of((real)0.f, (real)0.f, (real)0.f);
    int at = 0;
{where}    return place;
}}
static inline void light_place_span(const struct world *world, integer light, vector origin, vector direction,
                                    real *near, real *far) {{
    int at = 0;
    real low, high;
    mask chosen;
{spans}}}
static inline void light_place_sample(const struct world *world, integer light, vector from, light_sample *s) {{
    const real v = (real)0.f, w = (real)0.f;
    int at = 0;
    light_sample other;
    s->towards = from, s->distance = s->pdf = (real)0.f, s->weight = spectrum_grey((real)0.f);
{samples}}}
"""


#: Density of scattering, where it finds what is sampled, too.
SCATTER_PDF = """\
static inline real scatter_pdf(const path *p, const struct world *world, vector out) {
    return world->scene->lights.both ? path_scatter_pdf(p, world, out) : (real)1e30f;
}
"""
