// A walk through a medium under one bound on σ_t, for scenes of several media; `t` is a length along the ray.
#include "core/rng.h"
#include "core/vector.h"
#include "majorant/global.h"
#include "majorant/walk.h"

typedef struct {
    real t, t_low, t_from; // where the walk is, what rounding left of it, and where its last step began
    real far, bound;       // where it ends; the majorant at t
} majorant_walk;

static inline void majorant_global_start(__constant const struct majorant_global *majorant, vector origin, vector along, real near,
                                         real far, majorant_walk *walk, mask chosen) {
    walk->t = pick(walk->t, near, chosen);
    walk->t_low = pick(walk->t_low, (real)0.f, chosen);
    walk->t_from = pick(walk->t_from, near, chosen);
    walk->far = pick(walk->far, far, chosen);
    walk->bound = (real)(1.f / majorant->mean_free_path);
}

static inline mask majorant_global_step(__constant const struct majorant_global *majorant, majorant_walk *walk, real depth,
                                        mask active) {
    walk->t_from = pick(walk->t_from, walk->t, active);
    walk_advance(&walk->t, &walk->t_low, depth * majorant_global_mean_free_path(majorant), active);
    mask left = active & ~test(walk->t < walk->far); // so that a NaN leaves, too
    walk->t = pick(walk->t, walk->far, left);
    return left;
}
