// A step through the majorant's grid that passes a control: walks meet tentative collisions at the rate of a bound on what
// σ_t is above it, flights at the majorant's. Cells are the control's as well.
#include "majorant/grid.h"

// `passed`: the optical depth of the control over the step, of walks.
static inline mask majorant_step_past_control(const struct world *world, majorant_walk *walk, real depth, mask active, mask walks,
                                              coefficient *passed) {
    mask walking = active, left = (mask)0;
    coefficient control = grids_minorant(world, walk);
    *passed = coefficient_grey((real)0.f);
    walk->t_from = pick(walk->t_from, walk->t, active);
    while (some(walking)) {
        vector plane = majorant_grid_planes(walk);
        real next = smaller(plane.x, smaller(plane.y, plane.z)), stop = smaller(next, walk->far);
        real length = larger((stop - walk->t) - walk->t_low, (real)0.f), spent = walk->bound * length;
        walking &= ~test(depth < spent);
        depth = pick(depth, depth - spent, walking);
        *passed = coefficient_pick(*passed, coefficient_add(*passed, coefficient_scale(control, length)), walking);
        walk->t = pick(walk->t, larger(stop, walk->t), walking);
        walk->t_low = pick(walk->t_low, (real)0.f, walking);
        mask out = walking & ~test(next < walk->far); // so that a NaN leaves, too
        left |= out;
        walking &= ~out;
        majorant_grid_cross(&world->scene->majorant, walk, plane, next, walking);
        real bound = majorant_cell(world, walk, world->majorant_grid_bounds);
        bound = pick(bound, majorant_cell(world, walk, world->majorant_residual), walks);
        walk->bound = pick(walk->bound, bound, walking);
        control = coefficient_pick(control, grids_minorant(world, walk), walking);
    }
    mask collided = active & ~left;
    real length = depth / pick((real)1.f, walk->bound, collided);
    *passed = coefficient_pick(*passed, coefficient_add(*passed, coefficient_scale(control, length)), collided);
    walk_advance(&walk->t, &walk->t_low, length, collided);
    return left;
}
