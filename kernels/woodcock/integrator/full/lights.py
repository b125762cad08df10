"""Calls into a scene's lights: what an escaping path finds, and one light chosen for next-event estimation."""

from __future__ import annotations

from collections.abc import Sequence

from woodcock.layout import Record, module


def literal(value: float) -> str:
    """A float of OpenCL C."""
    return f"{value!r}f"


def _call(record: Record, verb: str, arguments: str) -> str:
    names = getattr(module("light", record.kind), "BUFFERS", ())
    buffers = "".join(f"world->light_{record.kind}_{name}, " for name in names)
    return f"light_{record.kind}_{verb}(&world->scene->{record.member}, {buffers}{arguments})"


def escape(lights: Sequence[Record], sampled: int) -> str:
    """Radiance from behind everything, each light's weighed against its own samples; sampled: lights that are."""
    lines = []
    for light in lights:
        kind = module("light", light.kind)
        if not kind.ON_ESCAPE:
            continue
        found = _call(light, "radiance", "direction")
        if kind.SAMPLED:
            rival = f"{_call(light, 'pdf', 'direction')} * {literal(1 / sampled)}"
            found = f"spectrum_scale({found}, pdf / (pdf + {rival}))"
        lines.append(f"    sum = spectrum_add(sum, {found});\n")
    return f"""\
static inline spectrum light_escape(const struct world *world, vector direction, real pdf) {{
    spectrum sum = spectrum_grey((real)0.f);
{"".join(lines)}    return sum;
}}
"""


def choose(lights: Sequence[Record], shining_surfaces: bool) -> str:
    """One of the lights that must be sampled, each with the same probability, which weight and density hold."""
    sampled = [light for light in lights if module("light", light.kind).SAMPLED]
    count = len(sampled) + shining_surfaces
    calls, places = [], 0
    for light in sampled:
        place = -1
        if module("light", light.kind).LOCAL:
            place, places = places, places + 1
        calls.append((_sample(light, "&other"), place))
    if shining_surfaces:
        calls.append((f"surface_light_sample(world, from, u * {count}.f - {count - 1}.f, v, w, &other);", -1))
    picks = []
    for index, (call, place) in enumerate(calls):
        picks.append(f"""\
    chosen = test(u >= {literal(index / count)});
    if (some(chosen)) {{
        {call}
        s->towards = vector_pick(s->towards, other.towards, chosen);
        s->distance = pick(s->distance, other.distance, chosen);
        s->weight = spectrum_pick(s->weight, other.weight, chosen);
        s->pdf = pick(s->pdf, other.pdf, chosen);
        place = pick(place, (integer){place}, chosen);
    }}
""")
    return f"""\
#define LIGHT_CHANCE {literal(1 / count)}
// The light's index among points of light, or -1.
static inline integer light_choose(const struct world *world, vector from, real u, real v, real w, light_sample *s) {{
    integer place = (integer)-1;
    light_sample other;
    mask chosen;
    s->towards = from, s->distance = s->pdf = (real)0.f, s->weight = spectrum_grey((real)0.f);
{"".join(picks)}    s->weight = spectrum_scale(s->weight, (real){count}.f);
    s->pdf *= LIGHT_CHANCE;
    return place;
}}
"""


def places(lights: Sequence[Record]) -> str:
    """The points of light, for equiangular sampling."""
    local = [light for light in lights if module("light", light.kind).LOCAL]
    where, sample, spans = "", "", ""
    for index, light in enumerate(local):
        position = f"vector_uniform(world->scene->{light.member}.position)"
        where += f"    place = vector_pick(place, {position}, test(light == {index}));\n"
        if module("light", light.kind).SPANS:
            call = f"light_{light.kind}_span(&world->scene->{light.member}, origin, direction, &low, &high);"
            spans += f"""\
    low = *near, high = *far;
    {call}
    *near = pick(*near, low, test(light == {index}));
    *far = pick(*far, high, test(light == {index}));
"""
        sample += f"""\
    {_sample(light, "&other")}
    s->towards = vector_pick(s->towards, other.towards, test(light == {index}));
    s->distance = pick(s->distance, other.distance, test(light == {index}));
    s->weight = spectrum_pick(s->weight, other.weight, test(light == {index}));
"""
    return f"""\
#define PLACE_CHANCE {literal(1 / len(local))}
static inline vector light_place(const struct world *world, integer light) {{
    vector place = vector_of((real)0.f, (real)0.f, (real)0.f);
{where}    return place;
}}
// The part of a segment that the light can reach: near > far if there is none.
static inline void light_place_span(const struct world *world, integer light, vector origin, vector direction,
                                    real *near, real *far) {{
    real low, high;
{spans}}}
static inline void light_place_sample(const struct world *world, integer light, vector from, light_sample *s) {{
    const real v = (real)0.f, w = (real)0.f;
    light_sample other;
    s->towards = from, s->distance = (real)0.f, s->weight = spectrum_grey((real)0.f);
{sample}}}
"""


def _sample(light: Record, to: str) -> str:
    if light.kind == "directional":
        return (
            f"other.towards = light_directional_sample(&world->scene->{light.member}, &other.weight), "
            "other.distance = (real)1e30f, other.pdf = (real)0.f;"
        )
    return _call(light, "sample", f"from, v, w, {to}") + ";"


def surface_pdf(shining: bool) -> str:
    """With which density next-event estimation would have found a surface that a flight meets."""
    value = "surface_light_pdf(world, hit.primitive, from, at, direction) * LIGHT_CHANCE" if shining else "(real)0.f"
    return f"""\
static inline real surface_emission_pdf(const struct world *world, surface_hit hit, vector from, surface_point at,
                                        vector direction) {{
    return {value};
}}
"""
