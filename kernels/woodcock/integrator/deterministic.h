// What the integrators without random numbers share: camera rays at fixed places of a pixel, and the film.
#include "core/audit.h"
#include "core/bounded.h"
#include "core/sequence.h"

// A camera ray, from `near` on.
typedef struct {
    vector anchor, direction;
    real near;
} camera_path;

static inline camera_path camera_path_of(const struct world *world, integer x, integer y, uint sample) {
    camera_path ray;
    real u = to_real(x) + 0.5f + filter_offset(world, sequence_at(sample, 0u));
    real v = to_real(y) + 0.5f + filter_offset(world, sequence_at(sample, 1u));
    const number width = world->scene->film.width, height = world->scene->film.height;
    camera_ray(world, u / width, v / height, sample, &ray.anchor, &ray.direction, &ray.near);
    return ray;
}

// How far off `light` exp(-τ) may be, where τ may be by so many roundings; no more than all of the light.
static inline real transmitted_bound(real value, real light, real doubt) {
    return smaller(value * expm1(smaller((4.f + doubt) * EPSILON, (real)80.f)), light);
}

// A ray's radiance in one channel and a bound on its error, into the film; one that is no number counts as amiss.
static inline void film_add(moments *m, real value, real bound, audit *found, mask *bad) {
    mask fine = test(value >= 0.f) & test(value < INFINITY) & test(bound < INFINITY);
    audit_value(found, value, ~fine & ~*bad);
    *bad |= ~fine;
    bounded_add(m, pick((real)0.f, value, fine), pick((real)0.f, bound, fine));
}

static inline void film_store(const moments *sums, const audit *found, __global float *film, __global uint *faults) {
    const size_t lane0 = get_global_id(0) * LANES, pixels = get_global_size(0) * LANES;
    for (int c = 0; c < CHANNELS; ++c) moments_store(&sums[c], film + 4 * c * pixels + lane0, pixels);
    audit_store(found, faults + lane0, pixels);
}
