// Equiangular sampling, where the scene has points of light and every transmittance is known in closed form.
#include "integrator/full/shadows_walked.h"
#define equiangular_start equiangular_send
#include "integrator/full/equiangular.h"
#undef equiangular_start

static inline mask equiangular_start(path *p, const struct world *world, mask flying) {
    return world->scene->lights.places ? equiangular_send(p, world, flying) : (mask)0;
}
