"""The phase functions of a scene's media -> the kinds they use, records, buffers, and the calls that choose among them;
and how much of a phase function goes straight on.

Phase functions are normalised and sampled exactly, so `phase_eval` is the density of `phase_sample` too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from woodcock.layout import Record, instances, module
from woodcock.phase import mixture, two_lobe
from woodcock.phase.henyey_greenstein import NARROWEST
from woodcock.scene import HenyeyGreensteinPhase, IsotropicPhase, MixturePhase, Phase, TwoLobePhase
from woodcock.scene.phase import Component, Lobe

Arrays = dict[str, NDArray[np.generic]]


@dataclass(frozen=True)
class PhaseCode:
    """kinds: files to inline before `text`; records: members of the scene's struct, buffers: members of `world`.

    text: OpenCL C of `phase_sample(world, medium, in, u, v)` and `phase_eval(world, medium, in, out)`, where `medium`
    is the index into the phase functions composed; lanes of any other medium get `in` and 0.
    """

    kinds: tuple[str, ...]
    records: tuple[Record, ...]
    buffers: Arrays
    text: str


def compose(phases: Sequence[Phase]) -> PhaseCode:
    """The code for media by index; equal phase functions become one instance."""
    different = list(dict.fromkeys(phases))
    members = [(f"phase_{i}", phase) for i, phase in enumerate(different)]
    parts: list[tuple[str, Phase]] = []
    for member, phase in members:
        parts.append((member, phase))
        if isinstance(phase, MixturePhase):
            parts += [(f"{member}_{i}", component.phase) for i, component in enumerate(phase.components)]
    records, buffers = instances("phase", parts)
    text = [_mixture(member, phase) for member, phase in members if isinstance(phase, MixturePhase)]
    media = [[i for i, other in enumerate(phases) if other == phase] for phase in different]
    text.append(_dispatch(members, media))
    kinds = tuple(dict.fromkeys(phase.kind for _, phase in parts))
    return PhaseCode(kinds, tuple(records), buffers, "".join(text))


def _call(member: str, phase: Phase, verb: str, arguments: str) -> str:
    """A call of an instance: of its kind's function, or of the one written for a mixture."""
    if isinstance(phase, MixturePhase):
        return f"{member}_{verb}(world, {arguments})"
    names = getattr(module("phase", phase.kind), "BUFFERS", ())
    buffers = "".join(f"world->phase_{phase.kind}_{name}, " for name in names)
    return f"phase_{phase.kind}_{verb}(&world->scene->{member}, {buffers}{arguments})"


def _mixture(member: str, phase: MixturePhase) -> str:
    """A mixture's functions: the sum, and the choice of one component by `u`, whose rest samples that component."""
    terms, choices = [], []
    for i, component in enumerate(phase.components):
        part = f"{member}_{i}"
        terms.append(f"mixture->weight_{i} * {_call(part, component.phase, 'eval', 'in, out')}")
        rest = f"phase_mixture_rest(u, mixture->start_{i}, mixture->weight_{i})"
        choices.append(f"""\
    chosen = phase_mixture_takes(u, mixture->start_{i}, mixture->start_{i + 1});
    if (some(chosen)) out = vector_pick(out, {_call(part, component.phase, "sample", f"in, {rest}, v")}, chosen);
""")
    pointer = f"__constant const struct phase_mixture *mixture = &world->scene->{member};"
    return f"""\
static inline vector {member}_sample(const struct world *world, vector in, real u, real v) {{
    {pointer}
    vector out = in;
    mask chosen;
{"".join(choices)}    return out;
}}
static inline real {member}_eval(const struct world *world, vector in, vector out) {{
    {pointer}
    return {" + ".join(terms)};
}}
"""


def _dispatch(members: list[tuple[str, Phase]], media: list[list[int]]) -> str:
    if len(members) == 1:
        sample = f"    return {_call(*members[0], 'sample', 'in, u, v')};\n"
        evaluate = f"    return {_call(*members[0], 'eval', 'in, out')};\n"
    else:
        sample, evaluate = "    vector to = in;\n    mask here;\n", "    real value = (real)0.f;\n    mask here;\n"
        for member, indices in zip(members, media, strict=True):
            here = f"    here = {' | '.join(f'test(medium == {index})' for index in indices)};\n"
            sample += f"{here}    if (some(here)) to = vector_pick(to, {_call(*member, 'sample', 'in, u, v')}, here);\n"
            evaluate += f"{here}    if (some(here)) value = pick(value, {_call(*member, 'eval', 'in, out')}, here);\n"
        sample, evaluate = sample + "    return to;\n", evaluate + "    return value;\n"
    return f"""\
static inline vector phase_sample(const struct world *world, integer medium, vector in, real u, real v) {{
{sample}}}
static inline real phase_eval(const struct world *world, integer medium, vector in, vector out) {{
{evaluate}}}
"""


def delta_fraction(phase: Phase) -> float:
    """The share that goes straight on: Henyey–Greenstein lobes narrower than float32 tells from a beam.

    A medium scatters the same with it taken away: σ_s' = (1 - f) σ_s, σ_t' = σ_t - f σ_s, phase `without_delta`.
    """
    if isinstance(phase, HenyeyGreensteinPhase):
        return 1.0 if phase.g > NARROWEST else 0.0
    parts = [(share, delta_fraction(part)) for share, part in _parts(phase) if share > 0]
    fractions = {fraction for _, fraction in parts}
    if fractions <= {0.0} or fractions == {1.0}:  # exactly, whatever the shares sum to
        return max(fractions, default=0.0)
    return sum(share * fraction for share, fraction in parts)


def without_delta(phase: Phase) -> Phase:
    """The rest of the phase function, normalised again; isotropic where nothing is left, for no light meets it."""
    if delta_fraction(phase) == 1:
        return IsotropicPhase()
    parts = _parts(phase)
    rest = [
        ((1 - delta_fraction(part)) * share, without_delta(part))
        for share, part in parts
        if share > 0 and delta_fraction(part) < 1
    ]
    if not parts or [part for _, part in rest] == [part for _, part in parts]:
        return phase
    if len(rest) == 1:
        return rest[0][1]
    return MixturePhase(components=tuple(Component(weight=share, phase=part) for share, part in rest))


def _parts(phase: Phase) -> list[tuple[float, Lobe]]:
    """What a phase function is the sum of, each with its share, as far as it may hold lobes that go straight on."""
    if isinstance(phase, TwoLobePhase):
        return list(two_lobe.lobes(phase))
    if isinstance(phase, MixturePhase):
        return [(float(w), part.phase) for w, part in zip(mixture.weights(phase), phase.components, strict=True)]
    return []
