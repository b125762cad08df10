// A disk: middle, unit normal, radius.
#include "core/frame.h"
#include "core/gather.h"
#include "core/sincos.h"
#include "surface/point.h"

static inline mask surface_disk_intersect(__global const float *numbers, integer at, vector origin, vector direction, real *t) {
    vector to = vector_along(vector_gather(numbers, at), (real)-1.f, origin), n = vector_gather(numbers, at + 3);
    real radius = gather(float, numbers, at + 6), along = vector_dot(n, direction);
    *t = vector_dot(n, to) / along;
    vector p = vector_of(*t * direction.x - to.x, *t * direction.y - to.y, *t * direction.z - to.z);
    return test(vector_dot(p, p) <= radius * radius) & test(*t > 0.f) & surface_is_ahead(n, to, along);
}

static inline void surface_disk_locate(__global const float *numbers, integer at, vector origin, vector direction, real t,
                                       surface_point *point) {
    vector c = vector_gather(numbers, at), n = vector_gather(numbers, at + 3);
    real radius = gather(float, numbers, at + 6);
    vector p = vector_along(vector_along(origin, (real)-1.f, c), t, direction);
    // Moved back onto the plane: the ray's length leaves no error along the normal.
    p = vector_along(p, -vector_dot(n, p), n);
    point->position = vector_along(p, (real)1.f, c);
    point->geometric = n;
    point->error = surface_error(n, vector_of(radius + fabs(c.x), radius + fabs(c.y), radius + fabs(c.z)));
}

// Uniform in area.
static inline void surface_disk_emit(__global const float *numbers, integer at, real u, real v, surface_point *point) {
    vector c = vector_gather(numbers, at), n = vector_gather(numbers, at + 3);
    real sine, cosine, radius = gather(float, numbers, at + 6), r = radius * sqrt(u);
    sincos_turns(v, &sine, &cosine);
    point->position = vector_along(c, (real)1.f, frame_to_world(n, r * cosine, r * sine, (real)0.f));
    point->geometric = n;
    point->error = surface_error(n, vector_of(radius + fabs(c.x), radius + fabs(c.y), radius + fabs(c.z)));
}
