// How walks go on through a grid of cells whose bounds hold for blocks around them, too: from each block to the cell behind
// it, where that has a block of its own. The three lowest bits of a bound tell how many cells its block has to every side,
// 2^n - 1, and lift it by no more than rounding would. After Cohen & Sheffer, "Proximity clouds - an acceleration technique for
// 3D grid traversal", The Visual Computer 11, 1994, with bounds in place of emptiness.
#include "core/rng.h"
#include "core/vector.h"
#include "majorant/walk.h"

typedef struct {
    real t, t_low, t_from; // where the walk is, what rounding left of it, and where its last step began
    real far, bound;       // where it ends; the majorant at t
    vector cell;           // whole numbers
    vector per_plane, first_plane;
    vector forward, anchor, along; // 1 or -1; the ray, in cells
} majorant_walk;

static inline vector majorant_grid_times(vector3 a, vector b) { return vector_of(a.x * b.x, a.y * b.y, a.z * b.z); }
static inline real majorant_grid_side(real per_plane) { return pick((real)-1.f, (real)1.f, test(per_plane > 0.f)); }

static inline void majorant_grid_course(__constant const struct majorant_grid *majorant, vector origin, vector along, majorant_walk *walk,
                                        mask chosen) {
    vector per = walk->per_plane;
    vector forward = vector_of(majorant_grid_side(per.x), majorant_grid_side(per.y), majorant_grid_side(per.z));
    walk->forward = vector_pick(walk->forward, forward, chosen);
    walk->anchor = vector_pick(walk->anchor, majorant_grid_times(majorant->per_cell, origin), chosen);
    walk->along = vector_pick(walk->along, majorant_grid_times(majorant->per_cell, along), chosen);
}

// Cells to every side, by the exponent of a float.
static inline real majorant_grid_reach(const majorant_walk *walk) {
    return word_as_real(((real_as_word(walk->bound) & 7u) + 127u) << 23) - 1.f;
}

// Where a walk leaves its block along each axis, and how it goes on to the next.
static inline vector majorant_grid_planes(const majorant_walk *walk) {
    vector per = walk->per_plane, first = walk->first_plane, last = vector_along(walk->cell, majorant_grid_reach(walk), walk->forward);
    return vector_of(fma(last.x, per.x, -first.x), fma(last.y, per.y, -first.y), fma(last.z, per.z, -first.z));
}

// Along an axis that is not crossed, by where the ray is, to a rounding, which bounds allow for; but never back, so that
// every walk ends, and never outside.
static inline real majorant_grid_next(real cell, real forward, real reach, real place, int cells, mask crossed) {
    real last = fma(forward, reach, cell), low = larger(smaller(cell, last), (real)0.f);
    real high = smaller(larger(cell, last), (real)(float)(cells - 1));
    return pick(larger(smaller(to_real(to_integer(place)), high), low), last + forward, crossed);
}

static inline void majorant_grid_cross(__constant const struct majorant_grid *majorant, majorant_walk *walk, vector plane, real next,
                                       mask crossing) {
    real reach = majorant_grid_reach(walk);
    vector c = walk->cell, forward = walk->forward, place = vector_along(walk->anchor, next, walk->along);
    c.x = majorant_grid_next(c.x, forward.x, reach, place.x, majorant->cells_x, test(plane.x == next));
    c.y = majorant_grid_next(c.y, forward.y, reach, place.y, majorant->cells_y, test(plane.y == next));
    c.z = majorant_grid_next(c.z, forward.z, reach, place.z, majorant->cells_z, test(plane.z == next));
    walk->cell = vector_pick(walk->cell, c, crossing);
}
