// A pinhole. Rays are anchored on a plane through the scene's middle, computed in float64 on the host, so that a camera
// a million object sizes away loses no precision; `start` is where the pinhole lies on the ray, relative to the anchor.
#include "core/vector.h"

static inline void camera_perspective_ray(__constant const struct camera_perspective *camera, real u, real v,
                                          vector *anchor, vector *direction, real *start) {
    vector corner = vector_uniform(camera->corner), right = vector_uniform(camera->right), down = vector_uniform(camera->down);
    *anchor = vector_along(vector_along(corner, u, right), v, down);
    vector away = vector_along(*anchor, (real)-1.f, vector_uniform(camera->origin));
    real distance = sqrt(vector_dot(away, away));
    *direction = vector_of(away.x / distance, away.y / distance, away.z / distance);
    *start = -distance;
}
