// Layers where the scene's record puts them.
#define ORDERS ((int)p->layers.at->orders)
#define ALBEDO ((int)p->layers.at->albedo)
#define NORMAL ((int)p->layers.at->normal)
#define DEPTH ((int)p->layers.at->depth)
#define OPTICAL_DEPTH ((int)p->layers.at->optical_depth)
#define TRANSMITTANCE ((int)p->layers.at->transmittance)
#define POSITION ((int)p->layers.at->position)
#define layers_begin layers_begin_there
#include "integrator/full/layers.h"
#undef layers_begin

static inline void layers_begin(path *p, const struct world *world, real lead, mask begin) {
    p->layers.at = &world->scene->layers;
    layers_begin_there(p, world, lead, begin);
}
