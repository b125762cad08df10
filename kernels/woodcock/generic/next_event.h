// Next-event estimation, where anything must be sampled.
#define next_event_start next_event_ask
#include "integrator/full/next_event.h"
#undef next_event_start

static inline mask next_event_start(path *p, const surface_state *s, const struct world *world, mask vertex) {
    return world->scene->lights.sampled ? next_event_ask(p, s, world, vertex) : (mask)0;
}
