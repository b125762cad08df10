// Where a ray meets a surface, and how a ray leaves it: Pharr, Jakob & Humphreys, "Physically Based Rendering", 4th edition,
// 6.8. A hit point's rounding error is bounded when it is computed; a ray that leaves starts beyond that bound.
#include "core/vector.h"

// t: distance along the ray, 1e30 where nothing is met; u, v: where on the primitive.
typedef struct {
    real t;
    integer primitive;
    real u, v;
} surface_hit;

// The normals point to the surface's own outside. `error` bounds how far `position` lies off the surface, along the
// geometric normal.
typedef struct {
    vector position, geometric, shading;
    real error;
    integer surface;
} surface_point;

// Bound on n · (error of p) for a point p that came of about ten roundings of numbers up to `size`, a vector of
// magnitudes. Twice 2^-24 for each, half of them for what the offset itself rounds.
static inline real surface_error(vector normal, vector size) {
    return 0x1.4p-20f * (fabs(normal.x) * fabs(size.x) + fabs(normal.y) * fabs(size.y) + fabs(normal.z) * fabs(size.z));
}

// Origin of a ray that leaves the point in `direction`, on that side of the surface.
static inline vector surface_leave(surface_point at, vector direction) {
    real side = copysign(at.error, vector_dot(direction, at.geometric));
    return vector_along(at.position, side, at.geometric);
}

// Does the plane with normal n (of any length) through a point at `to` from a ray's origin lie ahead of that ray, beyond
// doubt of rounding? A ray that has just left the plane does not meet it again.
static inline mask surface_is_ahead(vector n, vector to, real along_normal) {
    real x = n.x * to.x, y = n.y * to.y, z = n.z * to.z, distance = x + y + z;
    real doubt = 0x1p-20f * (fabs(x) + fabs(y) + fabs(z));
    return test(fabs(distance) > doubt) & test((distance > 0.f) == (along_normal > 0.f));
}

// Density per solid angle, seen from `from`, of a point taken uniformly in an area of 1; and the way to it.
static inline real surface_emit_flat(vector from, surface_point point, vector *towards, real *distance) {
    vector to = vector_along(point.position, (real)-1.f, from);
    real squared = vector_dot(to, to), facing;
    *distance = sqrt(squared);
    real s = 1.f / larger(*distance, (real)1e-20f);
    *towards = vector_of(to.x * s, to.y * s, to.z * s);
    facing = larger(fabs(vector_dot(*towards, point.geometric)), (real)1e-6f);
    // Surfaces close by in front of a slanted one are behind it by rounding.
    *distance -= 4.f * point.error / facing;
    return squared / facing;
}
