// Emission along flights, where any medium emits.
#define emission_of_piece emission_gathered
#include "integrator/full/emission.h"
#undef emission_of_piece

static inline void emission_of_piece(path *p, const struct world *world, real from, real from_low, real to, real to_low, mask flying) {
    if (world->scene->held.emitting) emission_gathered(p, world, from, from_low, to, to_low, flying);
}
