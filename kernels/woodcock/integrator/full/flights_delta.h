// Free flights by delta tracking: a tentative collision is real with probability σ_t / bound (Woodcock et al. 1965).
#include "core/audit.h"

static inline mask flights_meet(const path *p, const struct world *world, const majorant_walk *walk, words w, real u, audit *found,
                                mask flying, mask walking, integer *medium, coefficient *own, coefficient *sigma_t) {
    *sigma_t = grids_sigma_t(world, p, walk->t, w, u * walk->bound, medium, own);
    return flying & test(u * walk->bound < coefficient_of_hero(*sigma_t, p->hero));
}
