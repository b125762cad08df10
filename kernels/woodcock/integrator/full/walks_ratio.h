// Walks by ratio tracking: every tentative collision multiplies by 1 - σ_t / bound (Cramer 1978, Novák et al. 2014).
typedef struct { majorant_walk walk; } grid_state;

static inline void walks_start(path *p, const struct world *world, grid_state *g, mask begin) {}
static inline mask walks_step(const path *p, const struct world *world, grid_state *g, words w, real depth, mask active) {
    return majorant_step(world, &g->walk, depth, active);
}
static inline coefficient walks_residual(const struct world *world, const majorant_walk *walk, coefficient sigma_t, audit *found,
                                         mask event) {
    return sigma_t;
}
static inline real walks_size(coefficient transmittance) { return coefficient_max(transmittance); }

// What the step leaves of the walks' transmittance; returns lanes where it did.
static inline mask walks_pass(path *p, const struct world *world, grid_state *g, coefficient sigma_t, mask walking, mask *out,
                              coefficient *through) {
    mask event = walking & ~*out;
    for (int c = 0; c < COEFFICIENTS; ++c)
        coefficient_channel(*through, c) *= larger((real)0.f, 1.f - coefficient_channel(sigma_t, c) / g->walk.bound);
    walk_pass(p, sigma_t, g->walk.bound, event);
    return event;
}
