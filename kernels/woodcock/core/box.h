// A volume's bounds in its local space: from the origin to `size`.
#include "core/vector.h"

static inline real box_face(real o, real d, number size) {
    return pick((pick((real)0.f, (real)size, test(d > 0.f)) - o) / d, (real)1e30f, test(d == 0.f));
}

// Distance from a point inside to the face ahead; 0 or more.
static inline real box_exit(vector3 size, vector o, vector d) {
    real t = smaller(box_face(o.x, d.x, size.x), smaller(box_face(o.y, d.y, size.y), box_face(o.z, d.z, size.z)));
    return larger(t, (real)0.f);
}

static inline void box_slab(real o, real d, number size, real *near, real *far) {
    real a = -o / d, b = ((real)size - o) / d;
    mask parallel = test(d == 0.f), outside = parallel & (test(o < 0.f) | test(o > (real)size));
    *near = larger(*near, pick(pick(smaller(a, b), (real)-1e30f, parallel), (real)1e30f, outside));
    *far = smaller(*far, pick(larger(a, b), (real)1e30f, parallel));
}

// Where a ray from outside or inside runs through the box: near < far if it does at all.
static inline void box_clip(vector3 size, vector o, vector d, real *near, real *far) {
    box_slab(o.x, d.x, size.x, near, far);
    box_slab(o.y, d.y, size.y, near, far);
    box_slab(o.z, d.z, size.z, near, far);
}
