// The inside of a closed mesh. A path knows the meshes that it is in, one bit each, since it crosses them as surfaces.
#include "core/vector.h"

static inline void shape_mesh_interval(__constant const struct shape_mesh *shape, word inside, real *far) {
    *far = pick(*far, (real)-1e30f, test((inside & shape->bit) == 0u));
}
