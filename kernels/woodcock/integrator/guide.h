// Directions towards lights that next-event estimation alone finds. What a flight gathers of such a light is proportional to
// the phase function at its end, so that of all directions those matter where the product of two phase functions is large, that
// of the vertex and that of the next one towards the light. A small share of directions is sampled by the second, a
// Henyey-Greenstein lobe around the light, and weighed against the first by the balance heuristic of one sample (Veach & Guibas
// 1995): without them the few paths that come by such a direction are fireflies. A direction of the first alone then weighs
// 1 / (1 - share), which a path of many scatterings multiplies up; so the share falls with their number, and is small where the
// medium is opaque and where lobes are narrow (guide.py).
#include "phase/lobe_henyey_greenstein.h"

static inline real guide_share(const struct world *world, integer order) {
    return (real)world->scene->guide.share / ((real)world->scene->guide.settle + to_real(order));
}
static inline real guide_surface_share(const struct world *world, integer order) {
    return (real)world->scene->guide.surface_share / ((real)world->scene->guide.settle + to_real(order));
}
static inline vector guide_sample(const struct world *world, vector axis, real u, real v) {
    return lobe_henyey_greenstein_around((real)world->scene->guide.g, (real)world->scene->guide.gap, axis, u, 1.f - u, v);
}
static inline real guide_pdf(const struct world *world, real share, vector axis, vector to, real phase) {
    real lobe = lobe_henyey_greenstein_at(world->scene->guide.g, world->scene->guide.gap, axis, to);
    return phase + share * (lobe - phase);
}
// Towards a light in the scene, also from where it is.
static inline vector guide_towards(vector place, vector from) {
    vector to = vector_along(place, (real)-1.f, from);
    real inverse = 1.f / sqrt(larger(vector_dot(to, to), (real)1e-24f));
    return vector_of(to.x * inverse, to.y * inverse, to.z * inverse);
}
