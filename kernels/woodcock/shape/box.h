// A box; local space is the unit cube.
#include "core/box.h"

static inline mask shape_box_contains(__constant const struct shape_box *shape, vector p) {
    return test(p.x >= 0.f) & test(p.x <= 1.f) & test(p.y >= 0.f) & test(p.y <= 1.f) & test(p.z >= 0.f) & test(p.z <= 1.f);
}

// Where a ray of local space runs through it, within [near, far] as they come: near < far if it does at all.
static inline void shape_box_interval(__constant const struct shape_box *shape, vector origin, vector along, real *near, real *far) {
    vector3 size = {1.f, 1.f, 1.f};
    box_clip(size, origin, along, near, far);
}
