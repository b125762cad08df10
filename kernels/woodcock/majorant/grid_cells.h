// How walks go on through a grid of cells: from each to the next.
#include "core/rng.h"
#include "core/vector.h"
#include "majorant/walk.h"

typedef struct {
    real t, t_low, t_from; // where the walk is, what rounding left of it, and where its last step began
    real far, bound;       // where it ends; the majorant at t
    vector cell;           // whole numbers
    vector per_plane, first_plane;
} majorant_walk;

static inline void majorant_grid_course(__constant const struct majorant_grid *majorant, vector origin, vector along, majorant_walk *walk,
                                        mask chosen) {}

static inline real majorant_grid_next(real cell, real per_plane, mask crossed) {
    return cell + pick((real)0.f, pick((real)-1.f, (real)1.f, test(per_plane > 0.f)), crossed);
}

// Where a walk leaves its cell along each axis, and how it goes on to the next.
static inline vector majorant_grid_planes(const majorant_walk *walk) {
    vector cell = walk->cell, per = walk->per_plane, first = walk->first_plane;
    return vector_of(fma(cell.x, per.x, -first.x), fma(cell.y, per.y, -first.y), fma(cell.z, per.z, -first.z));
}

static inline void majorant_grid_cross(__constant const struct majorant_grid *majorant, majorant_walk *walk, vector plane, real next,
                                       mask crossing) {
    walk->cell.x = majorant_grid_next(walk->cell.x, walk->per_plane.x, crossing & test(plane.x == next));
    walk->cell.y = majorant_grid_next(walk->cell.y, walk->per_plane.y, crossing & test(plane.y == next));
    walk->cell.z = majorant_grid_next(walk->cell.z, walk->per_plane.z, crossing & test(plane.z == next));
}
