// How much optical depth of the majorant's grid lies ahead, and walks that begin again: for combs of evenly spaced points.
#include "majorant/grid.h"

static inline real majorant_ahead(const struct world *world, majorant_walk walk, real most, mask walking) {
    real depth = (real)0.f;
    while (some(walking)) {
        vector plane = majorant_grid_planes(&walk);
        real next = smaller(plane.x, smaller(plane.y, plane.z)), stop = smaller(next, walk.far);
        real spent = walk.bound * larger((stop - walk.t) - walk.t_low, (real)0.f);
        depth = pick(depth, depth + spent, walking);
        walk.t = pick(walk.t, larger(stop, walk.t), walking);
        walk.t_low = pick(walk.t_low, (real)0.f, walking);
        walking &= test(next < walk.far) & test(depth < most);
        majorant_grid_cross(&world->scene->majorant, &walk, plane, next, walking);
        real bound = majorant_grid_bound(&world->scene->majorant, world->majorant_grid_bounds, walk.cell);
        walk.bound = pick(walk.bound, bound, walking);
    }
    return smaller(depth, most);
}

static inline void majorant_restore(majorant_walk *walk, const majorant_walk *from, mask chosen) {
    walk->t = pick(walk->t, from->t, chosen);
    walk->t_low = pick(walk->t_low, from->t_low, chosen);
    walk->t_from = pick(walk->t_from, from->t_from, chosen);
    walk->far = pick(walk->far, from->far, chosen);
    walk->bound = pick(walk->bound, from->bound, chosen);
    walk->cell = vector_pick(walk->cell, from->cell, chosen);
    walk->per_plane = vector_pick(walk->per_plane, from->per_plane, chosen);
    walk->first_plane = vector_pick(walk->first_plane, from->first_plane, chosen);
}
