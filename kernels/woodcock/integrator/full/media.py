"""Calls into a scene's media: the clocks of constant ones, tracking through grids, albedo and emission by medium."""

from __future__ import annotations

from collections.abc import Sequence

from woodcock.scene import ConstantVolume, MeshShape, Volume


def local(i: int, volume: Volume, x: str) -> str:
    """A point of the device's space in the local space of medium i; a constant one is the same everywhere."""
    return x if isinstance(volume, ConstantVolume) else f"affine_point(&world->scene->medium_{i}.to_local, {x})"


def clocks(volumes: Sequence[Volume]) -> str:
    """Free flight and transmittance of constant media: exponential clocks, and exp(-τ), each in closed form."""
    constants = [(i, volume) for i, volume in enumerate(volumes) if isinstance(volume, ConstantVolume)]
    ring = "".join(
        f"""\
    clocks_interval_{i}(world, p, p->end, &near, &far);
    sigma_t = medium_{i}_sigma_t_exact(world, p->origin);
    ringing = flying & clocks_time(p, near, far, coefficient_of_hero(sigma_t, p->hero), flying, &t, &low);
    p->end = pick(p->end, t, ringing);
    p->end_low = pick(p->end_low, low, ringing);
    p->clock = pick(p->clock, (integer){i}, ringing);
"""
        for i, _ in constants
    )
    depth = "".join(
        f"""\
    clocks_interval_{i}(world, p, t, &near, &far);
    sigma_t = medium_{i}_sigma_t_exact(world, p->origin);
    sum = coefficient_add(sum, coefficient_scale(sigma_t, larger(far - near, (real)0.f)));
"""
        for i, _ in constants
    )
    own = "".join(
        f"    own = coefficient_pick(own, medium_{i}_sigma_t_exact(world, nowhere), test(medium == {i}));\n"
        for i, _ in constants
    )
    return (
        "".join(_interval(i, volume) for i, volume in constants)
        + f"""\
// Does the clock of a medium between near and far ring there, at what length, and what did rounding leave of that?
static inline mask clocks_time(path *p, real near, real far, real sigma_t, mask flying, real *t,
                               real *low) {{
    words w = rng_next(&p->random, flying);
    real unused, flight = rng_flight(&p->random, w, &unused) / sigma_t;
    *t = near + flight;
    mask ringing = test(flight < far - near + pick((real)0.f, p->end_low, test(far == p->end)));
    *low = pick((real)0.f, flight - (*t - near), ringing);
    return ringing;
}}
static inline void clocks_ring(const struct world *world, path *p, mask flying) {{
    if (!some(flying)) return;
    real near, far, t, low;
    coefficient sigma_t;
    mask ringing;
{ring}}}
// Optical depth of the constant media up to t.
static inline coefficient clocks_depth(const struct world *world, const path *p, real t) {{
    coefficient sigma_t, sum = coefficient_grey((real)0.f);
    real near, far;
{depth}    return sum;
}}
static inline coefficient clocks_own(const struct world *world, integer medium) {{
    coefficient own = coefficient_grey((real)0.f);
    const vector nowhere = {{(real)0.f, (real)0.f, (real)0.f}};
{own}    return own;
}}
"""
    )


def _interval(i: int, volume: ConstantVolume) -> str:
    local = f"&world->scene->shape_{i}"
    if isinstance(volume.shape, MeshShape):
        body = f"    shape_mesh_interval({local}, p->inside, far);\n"
    else:
        body = f"""\
    vector o = affine_point(&world->scene->shape_{i}.to_local, p->origin);
    vector d = affine_direction(&world->scene->shape_{i}.to_local, p->direction);
    shape_{volume.shape.kind}_interval({local}, o, d, near, far);
"""
    return f"""\
// Where the segment runs through medium {i}, from 0 to `to`: near < far if it does at all.
static inline void clocks_interval_{i}(const struct world *world, const path *p, real to, real *near, real *far) {{
    *near = (real)0.f;
    *far = to;
{body}}}
"""


def no_clocks() -> str:
    return """\
static inline void clocks_ring(const struct world *world, path *p, mask flying) {}
static inline coefficient clocks_depth(const struct world *world, const path *p, real t) {
    return coefficient_grey((real)0.f);
}
static inline coefficient clocks_own(const struct world *world, integer medium) { return coefficient_grey((real)0.f); }
"""


def spans(volumes: Sequence[Volume]) -> str:
    """Where constant media are along a segment, for equiangular sampling."""
    near_far = "".join(
        f"""\
    clocks_interval_{i}(world, p, p->reach, &a, &b);
    *near = pick(*near, smaller(*near, a), test(a < b));
    *far = pick(*far, larger(*far, b), test(a < b));
"""
        for i in range(len(volumes))
    )
    here = "".join(
        f"""\
    clocks_interval_{i}(world, p, p->reach, &a, &b);
    sigma_t = medium_{i}_sigma_t_exact(world, p->origin);
    sigma_t = coefficient_scale(sigma_t, pick((real)0.f, (real)1.f, test(a <= t) & test(t <= b)));
    total = coefficient_add(total, sigma_t);
    means[{i}] = coefficient_mean(sigma_t);
"""
        for i in range(len(volumes))
    )
    count = len(volumes)
    return f"""\
// The hull of the segment's parts in constant media: near < far if there are any.
static inline void clocks_span(const struct world *world, const path *p, real *near, real *far) {{
    real a, b;
    *near = (real)1e30f;
    *far = (real)-1e30f;
{near_far}}}
// σ_t of all media at t, and one of them, chosen by its share of it with u: `own` is its σ_t over its chance.
static inline coefficient clocks_sigma_t(const struct world *world, const path *p, real t, real u, integer *medium,
                                         coefficient *own) {{
    real a, b, means[{count}], sum = (real)0.f;
    coefficient sigma_t, total = coefficient_grey((real)0.f);
{here}    const real mean = coefficient_mean(total);
    *medium = (integer)-1;
    real chance = (real)1.f;
    for (int i = 0; i < {count}; ++i) {{
        mask chosen = test(*medium < 0) & test(u * mean < sum + means[i]);
        *medium = pick(*medium, (integer)i, chosen);
        chance = pick(chance, means[i] / mean, chosen);
        sum += means[i];
    }}
    *own = coefficient_scale(clocks_own(world, *medium), 1.f / chance);
    return total;
}}
"""


def grids(volumes: Sequence[Volume], majorant: str, majorant_buffers: str) -> str:
    """Calls into the majorant, and σ_t of all grids at once, with one of them chosen by its share."""
    indices = _grids(volumes)
    start = (
        f"majorant_{majorant}_start(&world->scene->majorant, {majorant_buffers}origin, along, near, far, walk, chosen)"
    )
    step = f"majorant_{majorant}_step(&world->scene->majorant, {majorant_buffers}walk, depth, active)"
    if len(indices) == 1:
        (i,) = indices
        body = f"""\
    *medium = (integer){i};
    vector at = affine_point(&world->scene->medium_{i}.to_local, vector_along(p->origin, t, p->direction));
    *own = medium_{i}_sigma_t(world, at, w);
    return *own;
"""
    else:
        each = "".join(
            f"""\
    sigma_t = medium_{i}_sigma_t(world, {local(i, volumes[i], "x")}, w);
    chosen = test(*medium < 0) & test(level < coefficient_of_hero(coefficient_add(total, sigma_t), p->hero));
    *medium = pick(*medium, (integer){i}, chosen);
    *own = coefficient_pick(*own, sigma_t, chosen);
    total = coefficient_add(total, sigma_t);
"""
            for i in indices
        )
        body = f"""\
    vector x = vector_along(p->origin, t, p->direction);
    coefficient sigma_t, total = coefficient_grey((real)0.f);
    mask chosen;
    *medium = (integer)-1;
    *own = total;
{each}    return total;
"""
    return f"""\
static inline void majorant_start(const struct world *world, vector origin, vector along, real near, real far,
                                  majorant_walk *walk, mask chosen) {{
    {start};
}}
static inline mask majorant_step(const struct world *world, majorant_walk *walk, real depth, mask active) {{
    return {step};
}}
// σ_t of the grids at t; `level`, uniform up to the bound, chooses the medium that collides.
static inline coefficient grids_sigma_t(const struct world *world, const path *p, real t, words w, real level,
                                        integer *medium, coefficient *own) {{
{body}}}
"""


def controls(volumes: Sequence[Volume]) -> str:
    """The least σ_t of all grids in a walk's cell, for transmittances that pass it in closed form."""
    each = "".join(f"    sum = coefficient_add(sum, medium_{i}_minorant(world, walk));\n" for i in _grids(volumes))
    return f"""\
static inline coefficient grids_minorant(const struct world *world, const majorant_walk *walk) {{
    coefficient sum = coefficient_grey((real)0.f);
{each}    return sum;
}}
"""


def decomposed(volumes: Sequence[Volume]) -> str:
    """σ_t of all grids as control and residual, for free flights that collide with either; one medium is chosen by its
    share of that."""
    known, rest = "", ""
    for i in _grids(volumes):
        known += f"""\
    least = medium_{i}_minorant(world, walk);
    chosen = test(*medium < 0) & test(level < coefficient_of_hero(coefficient_add(total, least), p->hero));
    *medium = pick(*medium, (integer){i}, chosen);
    *own = coefficient_pick(*own, least, chosen);
    total = coefficient_add(total, least);
"""
        rest += f"""\
    sigma_t = medium_{i}_sigma_t(world, {local(i, volumes[i], "x")}, w);
    above = control_residual(sigma_t, medium_{i}_minorant(world, walk));
    chosen = test(*medium < 0) & test(level < coefficient_of_hero(coefficient_add(below, above), p->hero));
    *medium = pick(*medium, (integer){i}, chosen);
    *own = coefficient_pick(*own, above, chosen);
    below = coefficient_add(below, above);
    total = coefficient_add(total, sigma_t);
"""
    return f"""\
// The control in the walk's cell, and the medium whose control holds `level`, or -1.
static inline coefficient grids_control(const struct world *world, const path *p, const majorant_walk *walk, real level,
                                        integer *medium, coefficient *own) {{
    coefficient least, total = coefficient_grey((real)0.f);
    mask chosen;
    *medium = (integer)-1;
    *own = total;
{known}    return total;
}}
// σ_t where the walk is, and the medium whose residual holds `level`, counted from the control, or -1.
static inline coefficient grids_residual(const struct world *world, const path *p, const majorant_walk *walk, words w,
                                         real level, integer *medium, coefficient *own) {{
    vector x = vector_along(p->origin, walk->t, p->direction);
    coefficient sigma_t, above, below = coefficient_grey((real)0.f), total = below;
    mask chosen;
    *medium = (integer)-1;
    *own = total;
{rest}    return total;
}}
"""


def _grids(volumes: Sequence[Volume]) -> list[int]:
    return [i for i, volume in enumerate(volumes) if not isinstance(volume, ConstantVolume)]


def albedo(volumes: Sequence[Volume]) -> str:
    """The albedo of medium `medium` at a point of the device's space."""
    calls = [f"medium_{i}_albedo(world, {local(i, volume, 'x')}, w)" for i, volume in enumerate(volumes)]
    lines = [f"    spectrum albedo = {calls[0] if calls else 'spectrum_grey((real)0.f)'};\n"]
    lines += [
        f"    albedo = spectrum_pick(albedo, {call}, test(medium == {i}));\n" for i, call in enumerate(calls) if i > 0
    ]
    return f"""\
static inline spectrum media_albedo(const struct world *world, integer medium, vector x, words w) {{
{"".join(lines)}    return albedo;
}}
"""


def emission(volumes: Sequence[Volume], *, tentative: bool) -> str:
    """ε by its two estimators: where a flight collides, and before that at tentative collisions or along pieces, ∫ ε by
    a random point of what each medium has of one. Where ε is linear in what a grid stores, by one tap; all taps are by
    the same words."""
    glowing = [(i, volume) for i, volume in enumerate(volumes) if volume.emission is not None]
    lookups = {i: f"medium_{i}_emission_once(world, at, w), medium_{i}_sigma_t(world, at, w)" for i, _ in glowing}
    met = "".join(
        f"""\
    at = {local(i, volume, "x")};
    found = emission_collided({lookups[i]});
    collided = spectrum_pick(collided, found, test(medium == {i}));
    along = spectrum_add(along, found);
"""
        for i, volume in glowing
    )
    text = f"""\
// Where a flight collides: the share of collisions of what `medium` emits, and the other share of all media, over κ.
static inline spectrum media_emitted(const struct world *world, integer medium, vector x, words w, spectrum *others) {{
    spectrum found, collided = spectrum_grey((real)0.f), along = collided;
    vector at;
{met}    *others = along;
    return collided;
}}
"""
    if tentative:
        return text
    pieces = "".join(_piece(i, volume, lookups[i]) for i, volume in glowing)
    return f"""\
{text}\
static inline spectrum media_emission(const struct world *world, const path *p, real from, real from_low, real to,
                                      real to_low, words w) {{
    const real u = unit(w.x);
    spectrum found, sum = spectrum_grey((real)0.f);
    real near, far, length, t;
    vector at;
{pieces}    return sum;
}}
"""


def _piece(i: int, volume: Volume, lookups: str) -> str:
    if isinstance(volume, ConstantVolume):
        clip = f"    clocks_interval_{i}(world, p, to, &near, &far);\n    near = larger(near, from);\n"
    else:
        clip = f"""\
    near = from, far = to;
    box_clip(world->scene->medium_{i}.size, {local(i, volume, "p->origin")},
             affine_direction(&world->scene->medium_{i}.to_local, p->direction), &near, &far);
"""
    return f"""\
{clip}    length = far - near + pick((real)0.f, to_low, test(far == to));
    length = larger(length - pick((real)0.f, from_low, test(near == from)), (real)0.f);
    t = near + u * length;
    at = {local(i, volume, "vector_along(p->origin, t, p->direction)")};
    found = emission_along({lookups});
    found = spectrum_scale(spectrum_multiply(found, path_weight_at(p, world, t)), length);
    sum = spectrum_pick(sum, spectrum_add(sum, found), test(length > 0.f));
"""
