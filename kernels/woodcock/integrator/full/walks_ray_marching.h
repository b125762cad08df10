// Walks by unbiased ray marching. They are cut into pieces of so much optical depth of the majorant at most, each with a
// series of its own, that what has lost its light after one of them does not go on through all others.
#include "tracking/ray_marching.h"

#define PIECE 8.f

typedef struct {
    majorant_walk walk, piece; // `piece`: where it begins
    ray_marching march;
    mask more;                 // there is another piece behind
} grid_state;

// A series for the piece that begins where the walks are.
static inline void walks_begin_piece(path *p, const struct world *world, grid_state *g, mask begin) {
    if (!some(begin)) return;
    majorant_restore(&g->piece, &g->walk, begin);
    real u, depth = majorant_ahead(world, g->walk, (real)PIECE, begin);
    words w = rng_next(&p->random, begin);
    rng_flight(&p->random, w, &u);
    transmittance_ray_marching_begin(&g->march, depth, u, begin);
    g->more = (g->more & ~begin) | (begin & test(depth >= PIECE));
}
static inline void walks_start(path *p, const struct world *world, grid_state *g, mask begin) {
    walks_begin_piece(p, world, g, begin);
}
static inline mask walks_step(const path *p, const struct world *world, grid_state *g, words w, real depth, mask active) {
    real march = transmittance_ray_marching_step(&g->march, unit(w.x));
    return majorant_step(world, &g->walk, pick(depth, march, p->walking), active);
}
static inline coefficient walks_residual(const struct world *world, const majorant_walk *walk, coefficient sigma_t, audit *found,
                                         mask event) {
    return sigma_t;
}
static inline real walks_size(coefficient transmittance) {
    real size = (real)0.f;
    for (int c = 0; c < COEFFICIENTS; ++c) size = larger(size, fabs(coefficient_channel(transmittance, c)));
    return size;
}

// What the step leaves of the walks' transmittance; returns lanes where it did: at the end of a piece. `out`: those that have
// come to the end of all.
static inline mask walks_pass(path *p, const struct world *world, grid_state *g, coefficient sigma_t, mask walking, mask *out,
                              coefficient *through) {
    transmittance_ray_marching_meet(&g->march, sigma_t, g->walk.bound, walking & ~*out);
    mask end = walking & (*out | test(g->march.left <= 0));
    *out &= ~walking;
    if (!some(end)) return end;
    mask again = transmittance_ray_marching_end(&g->march, end), whole = end & ~again;
    majorant_restore(&g->walk, &g->piece, end);
    if (some(whole)) {
        *through = coefficient_pick(*through, coefficient_multiply(*through, transmittance_ray_marching_value(&g->march)), whole);
        walk_pass_media(p, g->march.depth[0], whole);
        mask next = whole & g->more;
        if (some(next)) majorant_step(world, &g->walk, (real)PIECE, next);
        walks_begin_piece(p, world, g, next);
        *out |= whole & ~next;
    }
    return whole;
}
