"""Any phase functions: every medium's is a sum of components, each of any kind."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from woodcock.generic.slots import array, kinds
from woodcock.layout import Buffers, Record, module
from woodcock.phase.compose import compose
from woodcock.scene import MixturePhase, Phase
from woodcock.scene.phase import Lobe

LOBES = kinds(Lobe)
#: media: one bit each, of those whose phase function it is part of; at: in the kind's array; the rest as in a mixture.
COMPONENT = {"media": "uint", "kind": "int", "at": "int", "weight": "float", "start": "float", "next": "float"}
COUNT = {"components": "int"}
#: Components of all media, and instances of each kind.
ROOM, ROOM_OF_KIND = 32, 8


def phases(of_media: Sequence[Phase]) -> tuple[list[Record], Buffers]:
    """of_media: by the medium's index."""
    code = compose(of_media)
    members = {record.member: record for record in code.records}
    instances: dict[str, list[Any]] = {kind: [] for kind in LOBES}
    components: list[dict[str, Any]] = []
    for number, phase in enumerate(dict.fromkeys(of_media)):
        media = sum(1 << i for i, other in enumerate(of_media) if other == phase)
        parts = [(f"phase_{number}", {"weight": 1.0, "start": 0.0, "next": 2.0})]
        if isinstance(phase, MixturePhase):
            own = members[f"phase_{number}"].values
            parts = [
                (
                    f"phase_{number}_{i}",
                    {"weight": own[f"weight_{i}"], "start": own[f"start_{i}"], "next": own[f"start_{i + 1}"]},
                )
                for i in range(len(phase.components))
            ]
        for member, share in parts:
            lobe = members[member]
            place = {"media": media, "kind": LOBES.index(lobe.kind), "at": len(instances[lobe.kind])}
            components.append({**place, **share})
            instances[lobe.kind].append(lobe.values)
    records = [
        Record("phases", "", "phases", COUNT, {"components": len(components)}),
        array("component", "", "components", COMPONENT, components, ROOM),
        *(
            array("phase", kind, f"phase_{kind}", module("phase", kind).FIELDS, instances[kind], ROOM_OF_KIND)
            for kind in LOBES
        ),
    ]
    tables = {f"phase_{kind}_{name}" for kind in LOBES for name in getattr(module("phase", kind), "BUFFERS", ())}
    return records, {name: code.buffers.get(name, np.zeros(1, np.float32)) for name in sorted(tables)}


def text() -> str:
    """`phase_sample` and `phase_eval`."""
    samples, values = [], []
    for number, kind in enumerate(LOBES):
        names = getattr(module("phase", kind), "BUFFERS", ())
        own = f"&world->scene->phase_{kind}[part->at], " + "".join(f"world->phase_{kind}_{name}, " for name in names)
        samples.append(f"        if (part->kind == {number}) out = phase_{kind}_sample({own}in, rest, v);\n")
        values.append(f"        if (part->kind == {number}) own = phase_{kind}_eval({own}in, out);\n")
    head = """\
    const word bit = (word)1u << integer_as_word(medium & 31);
    for (int i = 0; i < world->scene->phases.components; ++i) {
        __constant const struct component *part = &world->scene->components[i];
        mask here = test((bit & (uint)part->media) != 0u)"""
    return f"""\
static inline vector phase_sample(const struct world *world, integer medium, vector in, real u, real v) {{
    vector to = in;
{head} & phase_mixture_takes(u, part->start, part->next);
        if (!some(here)) continue;
        real rest = phase_mixture_rest(u, part->start, part->weight);
        vector out = in;
{"".join(samples)}        to = vector_pick(to, out, here);
    }}
    return to;
}}
static inline real phase_eval(const struct world *world, integer medium, vector in, vector out) {{
    real value = (real)0.f;
{head};
        if (!some(here)) continue;
        real own = (real)0.f;
{"".join(values)}        value += pick((real)0.f, own * part->weight, here);
    }}
    return value;
}}
"""
