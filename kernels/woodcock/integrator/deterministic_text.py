"""Generated calls of the integrators without random numbers: camera rays at fixed places, what lies behind everything,
and rays through media, cell by cell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Lattice:
    """A grid of values that a medium interpolates. member: of `struct scene`, a `struct volume_field`."""

    member: str
    nearest: bool = False


@dataclass(frozen=True)
class Medium:
    """Medium i of a scene, whose text has `medium_<i>_sigma_t_exact(world, p)` and `medium_<i>_emission(world, p)`; for
    depths of grids `medium_<i>_sigma_t_pair(world, p, q)`, the sum at two points of a cell.

    to_local: C expression of the affine to the space of p, from device space; shape: kind and C expression of its
    struct, of a homogeneous medium; lattices: the grids that it interpolates, the first of which says where it is;
    emits: has it an emission?
    """

    to_local: str
    shape: tuple[str, str] | None = None
    lattices: tuple[Lattice, ...] = ()
    emits: bool = False


def files(media: Sequence[Medium], *, grey: bool) -> tuple[str, ...]:
    """Files that must come before `before_media`. grey: is every σ_t?"""
    shapes = dict.fromkeys(f"shape/{medium.shape[0]}.h" for medium in media if medium.shape)
    coefficient = f"core/coefficient_{1 if grey else 3}.h"
    return ("core/box.h", "core/cells.h", coefficient, "core/depth.h", "core/sequence.h", *shapes)


def camera(kind: str, filter_kind: str, *, lens: bool, sides: int) -> str:
    """Camera rays and filters. sides: the most voxels that a grid has along an axis."""
    places = "sequence_at(sample, 2u), sequence_at(sample, 3u), " if lens else ""
    return f"""\
#define MEDIA_ROUNDINGS {16 + 4 * sides}.f
static inline real filter_offset(const struct world *world, real u) {{
    return filter_{filter_kind}_offset(&world->scene->filter, u);
}}
static inline void camera_ray(const struct world *world, real u, real v, uint sample, vector *anchor,
                              vector *direction, real *near) {{
    camera_{kind}_ray(&world->scene->camera, u, v, {places}anchor, direction, near);
}}
"""


def radiance(lights: Sequence[str]) -> str:
    """lights: C expressions of the radiance that a ray of `direction` escapes to."""
    total = "spectrum_grey((real)0.f)"
    for light in lights:
        total = f"spectrum_add({total}, {light})"
    return f"""\
static inline spectrum light_radiance(const struct world *world, vector direction) {{
    return {total};
}}
"""


def walks(media: Sequence[Medium], *, emission: bool) -> str:
    """Rays through the media, to follow their own text: `media_depth` without emission, or `media_walk` with it."""
    text = "".join(_walk(f"medium_{index}", medium) for index, medium in enumerate(media))
    if emission:
        return text + _merged(media)
    depths = ""
    for index, medium in enumerate(media):
        text += _depth(f"medium_{index}", varies=bool(medium.lattices))
        depths += f"    depth = coefficient_add(depth, medium_{index}_depth(world, anchor, direction, near, doubt));\n"
    return f"""{text}\
// doubt: how far rounding may have put it off, in roundings.
static inline coefficient media_depth(const struct world *world, vector anchor, vector direction, real near,
                                      coefficient *doubt) {{
    coefficient depth = coefficient_grey((real)0.f);
    *doubt = depth;
{depths}    return depth;
}}
"""


def _walk(name: str, medium: Medium) -> str:
    """A ray through one medium: `near` to `far` where it lies; `doubt`, how many roundings it may be off for the places
    of these; and the planes at which its coefficients have kinks.
    """
    # A sphere's chord is a square root: what is off in its square is so twice over where it is short.
    stretch = "stretch * stretch" if medium.shape and medium.shape[0] == "sphere" else "stretch"
    members = planes = start = on = ""
    ahead = "walk->far"
    clip = f"shape_{medium.shape[0]}_interval(&{medium.shape[1]}" if medium.shape else ""
    for index, lattice in enumerate(medium.lattices):
        field, walk = f"world->scene->{lattice.member}", f"&walk->lattice_{index}"
        if index == 0:
            clip = f"cell_planes_clip({name}_planes_0(world), &{field}.from_local"
        members += f" cell_walk lattice_{index};"
        planes += f"""\
static inline cell_planes {name}_planes_{index}(const struct world *world) {{
    return cell_planes_of({field}.width, {field}.height, {field}.depth, {0.0 if lattice.nearest else 0.5}f);
}}
"""
        start += f"""
    cell_walk_start({walk}, {name}_planes_{index}(world), affine_point(&{field}.from_local, walk->origin),
                    affine_direction(&{field}.from_local, walk->along), walk->near);"""
        on += f"\n    cell_walk_pass({walk}, {name}_planes_{index}(world), to, active);"
        ahead = f"smaller(cell_walk_next({walk}), {ahead})"
    return f"""\
typedef struct {{ vector origin, along; real near, far, doubt; mask inside;{members} }} {name}_walk;
{planes}\
static inline void {name}_start(const struct world *world, {name}_walk *walk, vector anchor, vector direction,
                                real near) {{
    walk->origin = affine_point(&{medium.to_local}, anchor);
    walk->along = affine_direction(&{medium.to_local}, direction);
    walk->near = near;
    walk->far = (real)1e30f;
    {clip}, walk->origin, walk->along, &walk->near, &walk->far);
    real reach = fabs(walk->near) + fabs(walk->far) + 1.f / sqrt(vector_dot(walk->along, walk->along));
    real stretch = 1.f + reach / (walk->far - walk->near);
    walk->doubt = pick((real)0.f, MEDIA_ROUNDINGS * {stretch}, test(walk->near < walk->far));{start}
}}
// Where the coefficients of the medium may next have a kink or a jump.
static inline real {name}_next(const {name}_walk *walk, real from) {{
    real next = pick({ahead}, walk->near, test(from < walk->near));
    return pick(next, (real)1e30f, test(from >= walk->far) | test(walk->near >= walk->far));
}}
static inline void {name}_pass(const struct world *world, {name}_walk *walk, real to, mask active) {{{on}
}}
"""


def _depth(name: str, *, varies: bool) -> str:
    """The medium's optical depth along a ray."""
    head = f"""\
static inline coefficient {name}_depth(const struct world *world, vector anchor, vector direction, real near,
                                       coefficient *doubt) {{
    const coefficient none = coefficient_grey((real)0.f);
    {name}_walk walk;
    {name}_start(world, &walk, anchor, direction, near);
    mask active = test(walk.near < walk.far);
"""
    if not varies:
        return f"""{head}\
    real middle = pick((real)0.f, 0.5f * (walk.near + walk.far), active);
    coefficient sigma = {name}_sigma_t_exact(world, vector_along(walk.origin, middle, walk.along));
    coefficient depth = coefficient_pick(none, coefficient_scale(sigma, walk.far - walk.near), active);
    *doubt = coefficient_add(*doubt, coefficient_scale(depth, walk.doubt));
    return depth;
}}
"""
    return f"""{head}\
    optical_depth depth = {{none, none}};
    real from = walk.near;
    while (some(active)) {{
        // Gauss's two points, 1/√3 of the way from the middle to the ends: exact for a cubic.
        real to = larger({name}_next(&walk, from), from), wide = 0.5f * (to - from), middle = from + wide;
        real away = wide * (number)0.57735026918962576;
        coefficient both = {name}_sigma_t_pair(world, vector_along(walk.origin, middle - away, walk.along),
                                               vector_along(walk.origin, middle + away, walk.along));
        coefficient step = coefficient_scale(both, wide);
        optical_depth_add(&depth, coefficient_pick(none, step, active));
        {name}_pass(world, &walk, to, active);
        from = pick(from, to, active);
        active &= test(from < walk.far) & optical_depth_is_finite(&depth);
    }}
    *doubt = coefficient_add(*doubt, coefficient_scale(depth.sum, walk.doubt));
    return depth.sum;
}}
"""


def _merged(media: Sequence[Medium]) -> str:
    """The media together, piece by piece between the kinks of any."""

    def each(text: str) -> str:
        return "".join("\n    " + text.replace("$", f"medium_{index}") for index in range(len(media)))

    coefficients = ""
    for index, medium in enumerate(media):
        name = f"medium_{index}"
        lit = (
            f"\n        *epsilon = spectrum_pick(*epsilon, spectrum_add(*epsilon, {name}_emission(world, p)), inside);"
        )
        coefficients += f"""
    if (some(media->{name}.inside)) {{
        mask inside = media->{name}.inside;
        vector p = vector_along(media->{name}.origin, t, media->{name}.along);
        *sigma = coefficient_pick(*sigma, coefficient_add(*sigma, {name}_sigma_t_exact(world, p)), inside);\
{lit if medium.emits else ""}
    }}"""
    begins = "smaller(begin, pick((real)1e30f, media->$.near, test(media->$.near < media->$.far)))"
    ends = "larger(*end, pick(near, media->$.far, test(media->$.near < media->$.far)))"
    inside = "media->$.inside = test(middle > media->$.near) & test(middle < media->$.far);"
    return f"""\
typedef struct {{{each("$_walk $;")}
}} media_walk;
// Returns where the first medium begins; `end` is where the last one ends; `doubt` is the largest of any.
static inline real media_start(const struct world *world, media_walk *media, vector anchor, vector direction,
                               real near, real *end, real *doubt) {{
    real begin = (real)1e30f;
    *end = near;
    *doubt = (real)0.f;{each("$_start(world, &media->$, anchor, direction, near);")}{each(f"begin = {begins};")}\
{each(f"*end = {ends};")}{each("*doubt = larger(*doubt, media->$.doubt);")}
    return begin;
}}
// Where the piece ends that begins at `from`; notes which media lie there.
static inline real media_next(media_walk *media, real from, real end) {{
    real to = end;{each("to = smaller(to, $_next(&media->$, from));")}
    to = larger(to, from);
    real middle = 0.5f * (from + to);{each(inside)}
    return to;
}}
static inline void media_pass(const struct world *world, media_walk *media, real to, mask active) {{\
{each("$_pass(world, &media->$, to, active);")}
}}
static inline void media_coefficients(const struct world *world, const media_walk *media, real t, coefficient *sigma,
                                      spectrum *epsilon) {{
    *sigma = coefficient_grey((real)0.f);
    *epsilon = spectrum_grey((real)0.f);{coefficients}
}}
"""
