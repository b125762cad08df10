"""The generated calls: each goes to just the kinds of surfaces and materials that a scene uses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from woodcock.layout import module
from woodcock.surface.build import KINDS

_WORLD = "const struct world *world"
_TEST_RESULTS = {"sphere": "&t", "rectangle": "&t, &u, &v", "disk": "&t", "mesh": "&t, &u, &v"}
_TEST_RAY = {"mesh": "&prepared->mesh, origin"}
_LOCATE = {"sphere": "origin, direction, hit.t", "rectangle": "hit.u, hit.v", "mesh": "hit.u, hit.v"}
_LOCATE["disk"] = _LOCATE["sphere"]


#: Kind, first number, body.
PRIMITIVE = """\
static inline integer surface_primitive(const struct world *world, integer primitive, int member) {
    const integer known = pick(primitive, (integer)0, test(primitive < 0));
    return gather(int, world->surface_primitives, 3 * known + member);
}
"""


def tests(kinds: Sequence[str]) -> str:
    """What traverse.h calls; to come before it."""
    mesh = "mesh" in kinds
    prepared = "surface_mesh_shear mesh;" if mesh else "int unused;"
    prepare = "{surface_mesh_prepare(direction)}" if mesh else "{0}"
    lines = [
        f"typedef struct {{ {prepared} }} surface_prepared;",
        "static inline surface_prepared surface_prepare(vector direction) {",
        f"    surface_prepared prepared = {prepare};",
        "    return prepared;",
        "}",
        f"static inline mask surface_test({_WORLD}, const surface_prepared *prepared,",
        "                                integer primitive, vector origin, vector direction, mask tried,",
        "                                surface_hit *hit) {",
        "    const integer kind = surface_primitive(world, primitive, 0);",
        "    const integer first = surface_primitive(world, primitive, 1);",
        "    mask met = (mask)0;",
    ]
    for kind in kinds:
        ray = _TEST_RAY.get(kind, "origin, direction")
        lines += [
            f"    const mask of_{kind} = tried & test(kind == {KINDS.index(kind)});",
            f"    if (some(of_{kind})) {{",
            "        real t = (real)0.f, u = (real)0.f, v = (real)0.f;",
            f"        const integer at = pick((integer)0, first, of_{kind});",
            f"        mask hits = surface_{kind}_intersect(world->surface_{kind}, at, {ray}, {_TEST_RESULTS[kind]});",
            f"        hits &= of_{kind};",
            "        hit->t = pick(hit->t, t, hits);",
            "        hit->u = pick(hit->u, u, hits);",
            "        hit->v = pick(hit->v, v, hits);",
            "        met |= hits;",
            "    }",
        ]
    return "\n".join([*lines, "    return met;", "}", ""])


def in_turn(primitives: NDArray[np.int32]) -> str:
    """`surface_intersect` for a few primitives, each tried by every ray; (n, 3): kind, first number, body. What is
    the same for all lanes is loaded once."""
    lines = [
        f"static inline surface_hit surface_intersect({_WORLD}, vector origin, vector direction, real limit,",
        "                                            mask active) {",
        "    surface_hit hit = {limit, (integer)-1, (real)0.f, (real)0.f};",
        "    real t, u, v;",
        "    mask closer;",
    ]
    for number, (position, first, _) in enumerate(primitives.tolist()):
        kind = KINDS[position]
        call = f"surface_{kind}_intersect(world->surface_{kind}, (integer){first}, origin, direction, "
        lines += [
            "    t = u = v = (real)0.f;",
            f"    closer = {call}{_TEST_RESULTS[kind]}) & active;",
            "    closer &= test(t < hit.t);",
            "    hit.t = pick(hit.t, t, closer);",
            f"    hit.primitive = pick(hit.primitive, (integer){number}, closer);",
            "    hit.u = pick(hit.u, u, closer);",
            "    hit.v = pick(hit.v, v, closer);",
        ]
    lines += ["    hit.t = pick(hit.t, (real)1e30f, test(hit.primitive < 0));", "    return hit;", "}", ""]
    return "\n".join(lines)


def locate(kinds: Sequence[str], smooth: bool) -> str:
    """`surface_locate`; smooth: meshes have normals."""
    lines = [
        f"static inline surface_point surface_locate({_WORLD}, surface_hit hit, vector origin,",
        "                                           vector direction) {",
        *_chosen("hit.primitive"),
    ]
    for kind in kinds:
        call = f"surface_{kind}_locate(world->surface_{kind}, at, {_LOCATE[kind]}, &other);"
        extra = []
        if kind == "mesh" and smooth:
            extra = [
                "        // Where the shading normal is turned away from a ray that sees the face, it is not used.",
                "        vector n = surface_mesh_shading(world->surface_mesh_normals, at, hit.u, hit.v,",
                "                                        other.geometric);",
                "        mask seen = test(vector_dot(n, direction) * vector_dot(other.geometric, direction) > 0.f);",
                "        shading = vector_pick(other.geometric, n, seen);",
            ]
        lines += _branch(kind, [f"        {call}", "        vector shading = other.geometric;", *extra], "shading")
    return "\n".join([*lines, "    return point;", "}", ""])


def _chosen(primitive: str) -> list[str]:
    return [
        f"    const integer kind = surface_primitive(world, {primitive}, 0);",
        f"    const integer first = surface_primitive(world, {primitive}, 1);",
        "    surface_point point = {{(real)0.f, (real)0.f, (real)0.f}, {(real)0.f, (real)0.f, (real)1.f},",
        "                           {(real)0.f, (real)0.f, (real)1.f}, (real)0.f, (integer)0};",
        f"    point.surface = surface_primitive(world, {primitive}, 2);",
    ]


def _branch(kind: str, body: list[str], shading: str, after: Sequence[str] = ()) -> list[str]:
    return [
        f"    const mask of_{kind} = test(kind == {KINDS.index(kind)});",
        f"    if (some(of_{kind})) {{",
        f"        const integer at = pick((integer)0, first, of_{kind});",
        "        surface_point other = point;",
        *body,
        f"        point.position = vector_pick(point.position, other.position, of_{kind});",
        f"        point.geometric = vector_pick(point.geometric, other.geometric, of_{kind});",
        f"        point.shading = vector_pick(point.shading, {shading}, of_{kind});",
        f"        point.error = pick(point.error, other.error, of_{kind});",
        *after,
        "    }",
    ]


def emitters(kinds: Sequence[str]) -> str:
    """What emitters.h calls: a point on a primitive, and its density per solid angle but for the primitive's own."""
    lines = [
        "static inline real surface_emit(const struct world *world, integer primitive, vector from, real u, real v,",
        "                                vector *towards, real *distance, surface_point *found) {",
        *_chosen("primitive"),
    ]
    flat = [kind for kind in kinds if kind != "sphere"]
    for kind in flat:
        lines += _branch(
            kind, [f"        surface_{kind}_emit(world->surface_{kind}, at, u, v, &other);"], "other.geometric"
        )
    lines.append(
        "    real density = surface_emit_flat(from, point, towards, distance);"
        if flat
        else "    real density = (real)0.f;"
    )
    if "sphere" in kinds:
        if not flat:
            lines.append("    *towards = point.geometric; *distance = (real)0.f;")
        body = [
            "        vector way;",
            "        real length, d;",
            "        d = surface_sphere_emit(world->surface_sphere, at, from, u, v, &way, &length, &other);",
        ]
        after = [
            "        *towards = vector_pick(*towards, way, of_sphere);",
            "        *distance = pick(*distance, length, of_sphere);",
            "        density = pick(density, d, of_sphere);",
        ]
        lines += _branch("sphere", body, "other.geometric", after)
    lines += [
        "    *found = point;",
        "    return density;",
        "}",
        f"static inline real surface_emit_pdf({_WORLD}, integer primitive, vector from,",
        "                                    surface_point point, vector direction) {",
        "    vector way = vector_along(point.position, (real)-1.f, from);",
        "    real squared = vector_dot(way, way);",
        "    real density = squared / larger(fabs(vector_dot(direction, point.geometric)), (real)1e-6f);",
    ]
    if "sphere" in kinds:
        lines += [
            f"    const mask of_sphere = test(surface_primitive(world, primitive, 0) == {KINDS.index('sphere')});",
            "    if (some(of_sphere)) {",
            "        const integer at = pick((integer)0, surface_primitive(world, primitive, 1), of_sphere);",
            "        real d, length = sqrt(squared);",
            "        d = surface_sphere_emit_pdf(world->surface_sphere, at, from, direction, length, point);",
            "        density = pick(density, d, of_sphere);",
            "    }",
        ]
    return "\n".join([*lines, "    return density;", "}", ""])


def materials(used: Sequence[str], numbers: Sequence[str]) -> str:
    """`material_sample`, `material_eval` and the questions about materials; to come after records.h."""
    ids = {kind: numbers.index(kind) for kind in used}

    def masks(kinds: Sequence[str]) -> str:
        return " | ".join(f"test(kind == {ids[kind]})" for kind in kinds) or "(mask)0"

    delta = [kind for kind in used if module("material", kind).DELTA]
    head = "    const integer kind = surface_record(world, surface, 0), at = surface_record(world, surface, 1);"
    lines = [
        "static inline mask material_is_delta(const struct world *world, integer surface) {",
        "    const integer kind = surface_record(world, surface, 0);",
        f"    return {masks(delta)};",
        "}",
        "static inline mask material_is_null(const struct world *world, integer surface) {",
        "    const integer kind = surface_record(world, surface, 0);",
        f"    return {masks([kind for kind in used if kind == 'null'])};",
        "}",
        f"static inline spectrum material_emission({_WORLD}, integer surface, vector in,",
        "                                         vector geometric) {",
        "    spectrum radiance = spectrum_grey((real)0.f);",
    ]
    if "emissive" in used:
        lines += [
            head,
            f"    const mask shines = test(kind == {ids['emissive']});",
            "    const integer first = pick((integer)0, at, shines);",
            "    if (some(shines)) {",
            "        spectrum own = material_emissive_radiance(world->material_numbers, first, in, geometric);",
            "        radiance = spectrum_pick(radiance, own, shines);",
            "    }",
        ]
    arguments = "in, shading, geometric, u, v, w, &one_out, &one_weight, &one_pdf"
    lines += [
        "    return radiance;",
        "}",
        f"static inline void material_sample({_WORLD}, integer surface, vector in, vector shading,",
        "                                   vector geometric, real u, real v, real w, vector *out,",
        "                                   spectrum *weight, real *pdf) {",
        head,
        "    *out = in;",
        "    *weight = spectrum_grey((real)0.f);",
        "    *pdf = (real)0.f;",
    ]
    for kind in used:
        lines += [
            f"    const mask of_{kind} = test(kind == {ids[kind]});",
            f"    if (some(of_{kind})) {{",
            "        vector one_out;",
            "        spectrum one_weight;",
            "        real one_pdf;",
            f"        const integer first = pick((integer)0, at, of_{kind});",
            f"        material_{kind}_sample(world->material_numbers, first, {arguments});",
            f"        *out = vector_pick(*out, one_out, of_{kind});",
            f"        *weight = spectrum_pick(*weight, one_weight, of_{kind});",
            f"        *pdf = pick(*pdf, one_pdf, of_{kind});",
            "    }",
        ]
    lines += [
        "}",
        f"static inline void material_eval({_WORLD}, integer surface, vector in, vector out,",
        "                                 vector shading, vector geometric, spectrum *value, real *pdf) {",
        head,
        "    *value = spectrum_grey((real)0.f);",
        "    *pdf = (real)0.f;",
    ]
    for kind in used:
        if kind in delta:
            continue
        lines += [
            f"    const mask of_{kind} = test(kind == {ids[kind]});",
            f"    if (some(of_{kind})) {{",
            "        spectrum one_value;",
            "        real one_pdf;",
            f"        const integer first = pick((integer)0, at, of_{kind});",
            f"        material_{kind}_eval(world->material_numbers, first, in, out, shading, geometric, &one_value,",
            "                             &one_pdf);",
            f"        *value = spectrum_pick(*value, one_value, of_{kind});",
            f"        *pdf = pick(*pdf, one_pdf, of_{kind});",
            "    }",
        ]
    return "\n".join([*lines, "}", ""])
