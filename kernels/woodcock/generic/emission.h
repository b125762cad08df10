// Emission along flights, where any medium emits.
#define emission_of_piece emission_gathered
#define emission_of_collision emission_met
#include "integrator/full/emission_along.h"
#undef emission_of_piece
#undef emission_of_collision

static inline void emission_of_piece(path *p, const struct world *world, real from, real from_low, real to, real to_low, mask flying) {
    if (world->scene->held.emitting) emission_gathered(p, world, from, from_low, to, to_low, flying);
}

static inline void emission_of_collision(path *p, const struct world *world, integer medium, coefficient own, words w, mask collide) {
    if (world->scene->held.emitting) emission_met(p, world, medium, own, w, collide);
}
