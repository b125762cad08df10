// A bound on σ_t for every cell of a coarse grid over the tracking space, walked cell by cell: Amanatides & Woo, "A fast
// voxel traversal algorithm for ray tracing", Eurographics 1987; Szirmay-Kalos et al., "Free path sampling in high resolution
// inhomogeneous participating media", CGF 30(1), 2011. A step spends optical depth; cells of bound 0 cost no random numbers.
// Walks go on cell by cell, or by blocks of many: grid_cells.h or grid_hops.h, which say what a walk is made of, come first.
//
// Nothing accumulates: where the ray leaves cell c along an axis is c × `per_plane` - `first_plane`, from the integer c.
// The end is that of the last cells by the same formula, to the last bit, so no walk steps out of the grid or goes on for
// ever, whatever rounding does. Cells are bounded a little beyond their faces (grid.py), by more than rounding.

// One axis of a new walk. An axis along which the ray does not move has its planes infinitely far ahead.
static inline void majorant_grid_axis(real origin, real along, number per_cell, int cells, real near, real *cell, real *per_plane,
                                      real *first_plane, real *far) {
    real o = origin * per_cell, d = along * per_cell, last = (real)(float)(cells - 1);
    mask forward = test(d > 0.f), still = ~(test(d > 1e-30f) | test(d < -1e-30f));
    real inside = larger(smaller(floor(o + near * d), last), (real)0.f);
    real inverse = 1.f / d;
    *cell = inside;
    *per_plane = pick(inverse, (real)0.f, still);
    *first_plane = pick((o - pick((real)0.f, (real)1.f, forward)) * inverse, (real)-1e37f, still);
    *far = smaller(*far, fma(pick((real)0.f, last, forward), *per_plane, -*first_plane));
}

static inline real majorant_grid_bound(__constant const struct majorant_grid *majorant, __global const float *bounds, vector cell) {
    // Exact: there are at most 2^24 cells.
    real index = fma(cell.z, (real)(float)(majorant->cells_x * majorant->cells_y), fma(cell.y, (real)(float)majorant->cells_x, cell.x));
    return gather(float, bounds, to_integer(index));
}

static inline void majorant_grid_start(__constant const struct majorant_grid *majorant, __global const float *bounds, vector origin,
                                       vector along, real near, real far, majorant_walk *walk, mask chosen) {
    vector cell, per_plane, first_plane;
    majorant_grid_axis(origin.x, along.x, majorant->per_cell.x, majorant->cells_x, near, &cell.x, &per_plane.x, &first_plane.x, &far);
    majorant_grid_axis(origin.y, along.y, majorant->per_cell.y, majorant->cells_y, near, &cell.y, &per_plane.y, &first_plane.y, &far);
    majorant_grid_axis(origin.z, along.z, majorant->per_cell.z, majorant->cells_z, near, &cell.z, &per_plane.z, &first_plane.z, &far);
    walk->t = pick(walk->t, near, chosen);
    walk->t_low = pick(walk->t_low, (real)0.f, chosen);
    walk->t_from = pick(walk->t_from, near, chosen);
    walk->far = pick(walk->far, far, chosen);
    walk->bound = pick(walk->bound, majorant_grid_bound(majorant, bounds, cell), chosen);
    walk->cell = vector_pick(walk->cell, cell, chosen);
    walk->per_plane = vector_pick(walk->per_plane, per_plane, chosen);
    walk->first_plane = vector_pick(walk->first_plane, first_plane, chosen);
    majorant_grid_course(majorant, origin, along, walk, chosen);
}

static inline mask majorant_grid_step(__constant const struct majorant_grid *majorant, __global const float *bounds, majorant_walk *walk,
                                      real depth, mask active) {
    mask walking = active, left = (mask)0;
    walk->t_from = pick(walk->t_from, walk->t, active);
    while (some(walking)) {
        vector plane = majorant_grid_planes(walk);
        real next = smaller(plane.x, smaller(plane.y, plane.z)), stop = smaller(next, walk->far);
        mask inside = test(next < walk->far); // so that a NaN leaves, too
        // The next cell's bound is asked for before it is known who gets there, for it takes the longest.
        majorant_walk ahead = *walk;
        majorant_grid_cross(majorant, &ahead, plane, next, inside);
        ahead.bound = majorant_grid_bound(majorant, bounds, ahead.cell);
        real spent = walk->bound * larger((stop - walk->t) - walk->t_low, (real)0.f);
        walking &= ~test(depth < spent);
        depth = pick(depth, depth - spent, walking);
        walk->t = pick(walk->t, larger(stop, walk->t), walking);
        walk->t_low = pick(walk->t_low, (real)0.f, walking);
        left |= walking & ~inside;
        walking &= inside;
        walk->cell = vector_pick(walk->cell, ahead.cell, walking);
        walk->bound = pick(walk->bound, ahead.bound, walking);
    }
    mask collided = active & ~left;
    walk_advance(&walk->t, &walk->t_low, depth / pick((real)1.f, walk->bound, collided), collided);
    return left;
}
