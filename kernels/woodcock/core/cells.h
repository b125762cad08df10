// A ray through the cells of a grid. Between the planes where voxels' middles lie, an interpolated value is a polynomial
// along the ray: of third degree where it is trilinear, a number where it is the nearest voxel's (planes between voxels
// then); from the outermost planes to the grid's faces the border's values go on. Where the ray meets a plane is computed
// from the plane's number and never from the last one, so that nothing adds up.
#include "core/box.h"

// Voxels along each axis. Planes are at offset + …, -1, 0, 1, …, those beyond a face moved to it.
typedef struct { vector3 size; number offset; } cell_planes;

typedef struct {
    vector origin, along;  // of the ray, in the grid's space; t is a length in the scene
    vector plane, t;       // of each axis, the next plane and where the ray meets it
} cell_walk;

// offset: 1/2 for planes at voxels' middles, 0 for those at their faces.
static inline cell_planes cell_planes_of(number width, number height, number depth, number offset) {
    cell_planes planes = {{width, height, depth}, offset};
    return planes;
}

// Where a ray of the medium's local space runs through the grid, within [near, far] as they come.
static inline void cell_planes_clip(cell_planes planes, __constant const affine *from_local, vector origin, vector along, real *near, real *far) {
    box_clip(planes.size, affine_point(from_local, origin), affine_direction(from_local, along), near, far);
}

static inline real cell_meeting(real origin, real along, real plane, number size) {
    mask none = test(along == 0.f) | test(plane <= -1.f) | test(plane >= (real)(size + 1));
    real face = smaller(larger(plane, (real)0.f), (real)size);
    return pick((face - origin) / along, (real)1e30f, none);
}

// The first plane ahead of p.
static inline real cell_plane(real p, real along, number size, number offset) {
    real above = floor(p - offset) + (1 + offset), below = ceil(p - offset) + (offset - 1);
    above = pick(above, (real)-offset, test(p < 0.f));
    below = pick(below, (real)(size + offset), test(p > (real)size));
    return pick(below, above, test(along > 0.f));
}

static inline void cell_walk_meet(cell_walk *walk, cell_planes planes) {
    walk->t.x = cell_meeting(walk->origin.x, walk->along.x, walk->plane.x, planes.size.x);
    walk->t.y = cell_meeting(walk->origin.y, walk->along.y, walk->plane.y, planes.size.y);
    walk->t.z = cell_meeting(walk->origin.z, walk->along.z, walk->plane.z, planes.size.z);
}

static inline void cell_walk_start(cell_walk *walk, cell_planes planes, vector origin, vector along, real near) {
    walk->origin = origin;
    walk->along = along;
    vector p = vector_along(origin, near, along);
    walk->plane = vector_of(cell_plane(p.x, along.x, planes.size.x, planes.offset),
                            cell_plane(p.y, along.y, planes.size.y, planes.offset),
                            cell_plane(p.z, along.z, planes.size.z, planes.offset));
    cell_walk_meet(walk, planes);
}

// Where the ray meets the next plane of any axis.
static inline real cell_walk_next(const cell_walk *walk) { return smaller(walk->t.x, smaller(walk->t.y, walk->t.z)); }

// Moves on to `t`: axes whose plane has been reached take their next.
static inline void cell_walk_pass(cell_walk *walk, cell_planes planes, real t, mask active) {
    vector next = vector_of(walk->plane.x + copysign((real)1.f, walk->along.x),
                            walk->plane.y + copysign((real)1.f, walk->along.y),
                            walk->plane.z + copysign((real)1.f, walk->along.z));
    walk->plane = vector_of(pick(walk->plane.x, next.x, active & test(walk->t.x <= t)),
                            pick(walk->plane.y, next.y, active & test(walk->t.y <= t)),
                            pick(walk->plane.z, next.z, active & test(walk->t.z <= t)));
    cell_walk_meet(walk, planes);
}
