// Where a walk leaves its cell of the majorant's grid, along each axis, and how it goes on to the next.
static inline vector majorant_grid_planes(const majorant_walk *walk) {
    vector cell = walk->cell, per = walk->per_plane, first = walk->first_plane;
    return vector_of(fma(cell.x, per.x, -first.x), fma(cell.y, per.y, -first.y), fma(cell.z, per.z, -first.z));
}

static inline void majorant_grid_cross(majorant_walk *walk, vector plane, real next, mask crossing) {
    walk->cell.x = majorant_grid_next(walk->cell.x, walk->per_plane.x, crossing & test(plane.x == next));
    walk->cell.y = majorant_grid_next(walk->cell.y, walk->per_plane.y, crossing & test(plane.y == next));
    walk->cell.z = majorant_grid_next(walk->cell.z, walk->per_plane.z, crossing & test(plane.z == next));
}
