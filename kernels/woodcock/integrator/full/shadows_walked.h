// What is lost on the way to a light: the lane walks there, as a mode of its own. It returns the lanes that do.
#include "core/roulette.h"

static inline real shadow_chance(real scattered) { return roulette_walk(scattered); }

static inline mask shadow_cast(path *p, const surface_state *s, const struct world *world, const light_sample *sample, spectrum arriving,
                               mask lit, mask at_surface) {
    p->light = spectrum_pick(p->light, arriving, lit);
    walk_start(p, sample->towards, sample->distance, lit);
    surfaces_depart(s, p, world, lit & at_surface);
    return lit;
}

// From a vertex aside, for which the flight waits.
static inline mask shadow_cast_aside(path *p, const struct world *world, vector at, const light_sample *sample, spectrum arriving, mask lit) {
    p->position = vector_pick(p->position, p->origin, lit);
    p->incoming = vector_pick(p->incoming, p->direction, lit);
    p->inside_there = pick(p->inside_there, p->inside, lit);
    p->light = spectrum_pick(p->light, arriving, lit);
    p->aside |= lit;
    walk_start(p, sample->towards, sample->distance, lit);
    p->origin = vector_pick(p->origin, at, lit);
    return lit;
}
