// A sphere: centre and radius. Haines, Günther & Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection",
// Ray Tracing Gems, 2019: the discriminant from the ray's distance to the centre, roots without cancellation.
#include "core/gather.h"
#include "core/warp.h"
#include "surface/point.h"

static inline mask surface_sphere_intersect(__global const float *numbers, integer at, vector origin, vector direction, real *t) {
    vector f = vector_along(origin, (real)-1.f, vector_gather(numbers, at));
    real radius = gather(float, numbers, at + 3);
    real a = vector_dot(direction, direction), b = -vector_dot(f, direction);
    vector chord = vector_along(f, b / a, direction);
    real away = sqrt(vector_dot(chord, chord)), length = sqrt(vector_dot(f, f));
    real half_chord = sqrt(larger((radius - away) * (radius + away), (real)0.f) * a);
    real q = b + copysign(half_chord, b);
    // The two roots, far / q and q / a. `gap` is the origin's distance from the surface; below its rounding error the
    // origin lies on the surface, and the root near zero is where the ray comes from.
    real gap = length - radius;
    mask on = test(fabs(gap) <= 0x1p-21f * radius);
    real first = pick(gap * (length + radius) / q, (real)-1.f, on), second = q / a;
    real low = pick(second, first, test(b > 0.f)), high = pick(first, second, test(b > 0.f));
    *t = pick(high, low, test(low > 0.f));
    return test(away <= radius) & test(*t > 0.f);
}

static inline void surface_sphere_locate(__global const float *numbers, integer at, vector origin, vector direction, real t,
                                         surface_point *point) {
    vector center = vector_gather(numbers, at);
    real radius = gather(float, numbers, at + 3);
    // Moved back onto the sphere, so that the error is one of the radius and not of the ray's length.
    vector n = vector_normalize(vector_along(vector_along(origin, (real)-1.f, center), t, direction));
    point->position = vector_along(center, radius, n);
    point->geometric = n;
    point->error = surface_error(n, vector_of(radius + fabs(center.x), radius + fabs(center.y), radius + fabs(center.z)));
}

// Point to be lit from `from`: uniform in the cone that sees the sphere, whose half angle's versine keeps its precision
// however small the sphere looks; from inside uniform in area. Its density per solid angle.
static inline real surface_sphere_cone(__global const float *numbers, integer at, vector from, real *squared, real *radius,
                                       mask *outside) {
    vector to = vector_along(vector_gather(numbers, at), (real)-1.f, from);
    *radius = gather(float, numbers, at + 3);
    *squared = vector_dot(to, to);
    real sine2 = *radius * *radius / *squared;
    *outside = test(sine2 < 0.999f);
    return sine2 / (1.f + sqrt(larger(1.f - sine2, (real)0.f)));
}

static inline real surface_sphere_emit(__global const float *numbers, integer at, vector from, real u, real v,
                                       vector *towards, real *distance, surface_point *point) {
    vector center = vector_gather(numbers, at);
    real squared, radius;
    mask outside;
    real versine = surface_sphere_cone(numbers, at, from, &squared, &radius, &outside), whole = versine;
    versine = u * versine;
    // In the cone: its axis, the sine and the distance of the near side.
    vector axis = vector_along(center, (real)-1.f, from);
    real sine2 = versine * (2.f - versine), half_chord2 = larger(radius * radius - squared * sine2, (real)0.f);
    vector cone = warp_around(vector_normalize(axis), versine, v);
    real near = sqrt(squared) * (1.f - versine) - sqrt(half_chord2);
    // In area, where the origin lies inside.
    vector n = warp_around(vector_of((real)0.f, (real)0.f, (real)1.f), 2.f * u, v);
    n = vector_pick(n, vector_normalize(vector_along(vector_along(from, near, cone), (real)-1.f, center)), outside);
    point->position = vector_along(center, radius, n);
    point->geometric = n;
    point->error = surface_error(n, vector_of(radius + fabs(center.x), radius + fabs(center.y), radius + fabs(center.z)));
    vector to = vector_along(point->position, (real)-1.f, from);
    real length2 = vector_dot(to, to), length = sqrt(length2);
    vector straight = vector_of(to.x / length, to.y / length, to.z / length);
    *towards = vector_pick(straight, cone, outside);
    // Near the rim the ray grazes the sphere, and where it meets it is uncertain by as much as the chord is short.
    real doubt = 0x1p-18f * radius * radius / (sqrt(half_chord2) + 0x1p-9f * radius);
    *distance = pick(length, near - doubt, outside);
    real flat = length2 / (12.5663706f * radius * radius * larger(fabs(vector_dot(*towards, n)), (real)1e-6f));
    return pick(flat, 0.159154943f / whole, outside);
}

// The same density, of a direction that meets the sphere at a point of this distance.
static inline real surface_sphere_emit_pdf(__global const float *numbers, integer at, vector from, vector direction,
                                           real distance, surface_point point) {
    real squared, radius;
    mask outside;
    real versine = surface_sphere_cone(numbers, at, from, &squared, &radius, &outside);
    real facing = larger(fabs(vector_dot(direction, point.geometric)), (real)1e-6f);
    return pick(distance * distance / (12.5663706f * radius * radius * facing), 0.159154943f / versine, outside);
}
