// Parallel rays, anchored on a plane through the scene's middle; `start` is the camera's plane, relative to the anchor.
#include "core/vector.h"

static inline void camera_orthographic_ray(__constant const struct camera_orthographic *camera, real u, real v,
                                           vector *anchor, vector *direction, real *start) {
    vector corner = vector_uniform(camera->corner), right = vector_uniform(camera->right), down = vector_uniform(camera->down);
    *anchor = vector_along(vector_along(corner, u, right), v, down);
    *direction = vector_uniform(camera->direction);
    *start = (real)camera->start;
}
