"""Layout -> the text of a program made for it: only files of the kinds in use, their includes inlined with `#line`
marks (OpenCL's caches miss edits in included files), and generated calls that dispatch between them.

No string of a scene ever reaches the compiler: kinds are enumerated, numbers are uploaded.
"""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from woodcock.layout import Layout, Record, module

ROOT = Path(__file__).parent
OPTIONS = ("-cl-std=CL1.2",)
INCLUDE = re.compile(r'#include "(.+)"\n')


@dataclass(frozen=True)
class Program:
    """text: OpenCL C, self-contained; lanes: paths in lockstep of one work item."""

    text: str
    lanes: int

    @cached_property
    def hash(self) -> str:
        """sha256 of everything of ours that decides what is computed: the text and the options."""
        return hashlib.sha256("\n".join([*OPTIONS, self.text]).encode()).hexdigest()


def flatten(parts: list[str]) -> str:
    """Joins parts, each a file of this package or, where it holds a line break, generated text; a file comes once."""
    seen: set[str] = set()

    def inline(name: str) -> str:
        if name in seen:
            return ""
        seen.add(name)
        text, out, line = (ROOT / name).read_text(), [f'#line 1 "{name}"\n'], 1
        for piece in text.splitlines(keepends=True):
            line += 1
            include = INCLUDE.fullmatch(piece)
            if not include:
                out.append(piece)
            elif inlined := inline(include[1]):
                out.append(f'{inlined}#line {line} "{name}"\n')
            else:
                out.append("\n")
        return "".join(out)

    return "".join(f'#line 1 "generated"\n{part}' if "\n" in part else inline(part) for part in parts)


def compose(layout: Layout, lanes: int) -> Program:
    """The program of a scene for a width of lanes: 1, 4, 8 or 16."""
    parts = [f"core/lanes_{lanes}.h", "core/rng.h", "core/vector.h", f"core/spectrum_{layout.channels}.h"]
    parts.append(layout.structs())
    for concept, kinds in layout.kinds.items():
        if concept != "integrator":
            parts += [_file(concept, kind) for kind in kinds]
    parts += [_world(layout), _dispatch(layout), "core/path.h"]
    parts.append("integrator/next_event.h" if "transmittance" in layout.kinds else "integrator/no_next_event.h")
    (integrator,) = layout.kinds["integrator"]
    parts += [f"integrator/{integrator}.cl", _entry(layout, integrator)]
    return Program(flatten(parts), lanes)


def _file(concept: str, kind: str) -> str:
    if concept == "storage":
        return f"volume/grid_{kind}.h"
    return f"{'tracking' if concept in ('free_flight', 'transmittance') else concept}/{kind}.h"


def _buffers(layout: Layout) -> list[str]:
    return [f"__global const {name}_storage *{name}" for name in layout.buffers]


def _world(layout: Layout) -> str:
    members = "".join(f" {buffer};" for buffer in _buffers(layout))
    return f"struct world {{ __constant const struct scene *scene;{members} }};\n"


def _dispatch(layout: Layout) -> str:
    """The calls that the integrator makes, each to just the kinds that the scene uses."""
    (camera,), (volume,) = layout.kinds["camera"], layout.kinds["volume"]
    (phase,), (majorant,), (flight,) = (layout.kinds[name] for name in ("phase", "majorant", "free_flight"))
    buffers = "".join(f"world->{name}, " for name in layout.buffers)
    lights = [record for record in layout.records if record.concept == "light"]
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
static inline real majorant_mean_free_path(const struct world *world) {{
    return majorant_{majorant}_mean_free_path(&world->scene->majorant);
}}
static inline mask free_flight_collides(real density, real u) {{ return free_flight_{flight}_collides(density, u); }}
static inline vector phase_sample(const struct world *world, vector in, real u, real v) {{
    return phase_{phase}_sample(&world->scene->phase, in, u, v);
}}
static inline spectrum light_radiance(const struct world *world, vector direction) {{ return {radiance}; }}
"""
    if sampled:
        (transmittance,) = layout.kinds["transmittance"]
        text += f"""\
static inline real phase_eval(const struct world *world, vector in, vector out) {{
    return phase_{phase}_eval(&world->scene->phase, in, out);
}}
static inline mask transmittance_step(const struct world *world, real *value, real density, real length, mask escape,
                                      real u) {{
    return transmittance_{transmittance}_step(value, density, length, majorant_mean_free_path(world), escape, u);
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


def _entry(layout: Layout, integrator: str) -> str:
    arguments = [
        "__constant const struct scene *scene",
        *_buffers(layout),
        "__global float *film",
        "__global uint *faults",
        "uint first",
        "uint samples",
    ]
    members = "".join(f", {name}" for name in layout.buffers)
    return f"""
__kernel void render({", ".join(arguments)}) {{
    const struct world world = {{scene{members}}};
    {integrator}(&world, film, faults, first, samples);
}}
"""
