// A ball; local space has it at the origin with radius 1.
#include "core/vector.h"

static inline mask shape_sphere_contains(__constant const struct shape_sphere *shape, vector p) {
    return test(vector_dot(p, p) <= 1.f);
}

// Where a ray of local space runs through it, within [near, far] as they come: near < far if it does at all. From the
// ray's nearest point to the centre rather than by the quadratic's discriminant, b² - 4ac, which cancels from afar
// (Haines et al., "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019).
static inline void shape_sphere_interval(__constant const struct shape_sphere *shape, vector origin, vector along, real *near, real *far) {
    real squared = vector_dot(along, along), middle = -vector_dot(origin, along) / squared;
    vector nearest = vector_along(origin, middle, along);
    // (1 - r) (1 + r) keeps the digits of grazing rays.
    real r = sqrt(vector_dot(nearest, nearest));
    real half_chord = sqrt(larger((1.f - r) * (1.f + r), (real)0.f) / squared);
    mask outside = test(r > 1.f);
    *near = larger(*near, pick(middle - half_chord, (real)1e30f, outside));
    *far = smaller(*far, pick(middle + half_chord, (real)-1e30f, outside));
}
