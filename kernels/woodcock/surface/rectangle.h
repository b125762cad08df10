// A parallelogram: middle, half edges, unit normal, and the dual vectors that give a point's coordinates from -1 to 1.
#include "core/gather.h"
#include "surface/point.h"

// Rectangles reach 2^-20 of their size beyond their edges, so that neighbours leave no gap between them.
static inline mask surface_rectangle_intersect(__global const float *numbers, integer at, vector origin, vector direction,
                                               real *t, real *u, real *v) {
    vector to = vector_along(vector_gather(numbers, at), (real)-1.f, origin), n = vector_gather(numbers, at + 9);
    real along = vector_dot(n, direction);
    *t = vector_dot(n, to) / along;
    vector p = vector_of(*t * direction.x - to.x, *t * direction.y - to.y, *t * direction.z - to.z);
    *u = vector_dot(vector_gather(numbers, at + 12), p);
    *v = vector_dot(vector_gather(numbers, at + 15), p);
    return test(fabs(*u) <= 1.000001f) & test(fabs(*v) <= 1.000001f) & test(*t > 0.f) & surface_is_ahead(n, to, along);
}

static inline void surface_rectangle_locate(__global const float *numbers, integer at, real u, real v, surface_point *point) {
    vector c = vector_gather(numbers, at), a = vector_gather(numbers, at + 3), b = vector_gather(numbers, at + 6);
    vector n = vector_gather(numbers, at + 9);
    point->position = vector_along(vector_along(c, u, a), v, b);
    point->geometric = n;
    point->error = surface_error(n, vector_of(fabs(c.x) + fabs(a.x) + fabs(b.x), fabs(c.y) + fabs(a.y) + fabs(b.y),
                                              fabs(c.z) + fabs(a.z) + fabs(b.z)));
}

// Uniform in area.
static inline void surface_rectangle_emit(__global const float *numbers, integer at, real u, real v, surface_point *point) {
    surface_rectangle_locate(numbers, at, 2.f * u - 1.f, 2.f * v - 1.f, point);
}
