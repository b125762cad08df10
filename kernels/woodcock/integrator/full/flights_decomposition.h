// Free flights by decomposition tracking. The control is a lower bound on the σ_t of every medium, and a collision is that
// of a medium's control or of its residual: where σ_t has colour, the two weigh by densities of their own.
#include "core/audit.h"
#include "tracking/decomposition.h"

static inline mask flights_meet(const path *p, const struct world *world, const majorant_walk *walk, words w, real u, audit *found,
                                mask flying, mask walking, integer *medium, coefficient *own, coefficient *sigma_t) {
    const real level = u * walk->bound;
    coefficient minorant = grids_control(world, p, walk, level, medium, own);
    const real control = coefficient_of_hero(minorant, p->hero);
    mask known = flying & free_flight_decomposition_known(level, control), asked = (flying | walking) & ~known;
    *sigma_t = minorant;
    if (!some(asked)) return known;
    integer other;
    coefficient rest, found_there = grids_residual(world, p, walk, w, level - control, &other, &rest);
    audit_minorant(found, found_there, minorant, spectrum_max(p->throughput), asked);
    *sigma_t = coefficient_pick(*sigma_t, found_there, asked);
    *own = coefficient_pick(*own, rest, asked);
    *medium = pick(*medium, other, asked);
    // A sum of residuals may be an ulp short, and then there is no medium to collide with.
    mask real_one = free_flight_decomposition_collides(level, coefficient_of_hero(found_there, p->hero)) & test(other >= 0);
    return known | (flying & asked & real_one);
}
