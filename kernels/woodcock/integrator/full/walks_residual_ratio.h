// Walks by residual ratio tracking: their bound is one on what σ_t is above the control.
#include "tracking/residual_ratio.h"

typedef struct {
    majorant_walk walk;
    coefficient passed; // the control's optical depth over the step
} grid_state;

static inline void walks_start(path *p, const struct world *world, grid_state *g, mask begin) {
    g->walk.bound = pick(g->walk.bound, majorant_cell(world, &g->walk, world->majorant_residual), begin);
}
static inline mask walks_step(const path *p, const struct world *world, grid_state *g, words w, real depth, mask active) {
    return majorant_step_past_control(world, &g->walk, depth, active, active & p->walking, &g->passed);
}
static inline coefficient walks_residual(const struct world *world, const majorant_walk *walk, coefficient sigma_t, audit *found,
                                         mask event) {
    if (!some(event)) return sigma_t;
    coefficient minorant = grids_minorant(world, walk);
    audit_minorant(found, sigma_t, minorant, (real)1.f, event);
    return coefficient_pick(sigma_t, control_residual(sigma_t, minorant), event);
}
static inline real walks_size(coefficient transmittance) { return coefficient_max(transmittance); }

// What the step leaves of the walks' transmittance; returns lanes where it did.
static inline mask walks_pass(path *p, const struct world *world, grid_state *g, coefficient sigma_t, mask walking, mask *out,
                              coefficient *through) {
    mask event = walking & ~*out;
    coefficient control = transmittance_residual_ratio_control(g->passed);
    for (int c = 0; c < COEFFICIENTS; ++c) {
        real factor = transmittance_residual_ratio_factor(coefficient_channel(sigma_t, c), g->walk.bound);
        coefficient_channel(*through, c) *= coefficient_channel(control, c) * pick((real)1.f, factor, event);
    }
    walk_pass(p, sigma_t, g->walk.bound, event);
    walk_pass_media(p, g->passed, walking);
    return walking;
}
