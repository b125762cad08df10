// Every direction around a point: longitude across the film, latitude down it. Rays are anchored in the point itself.
#include "core/sincos.h"
#include "core/vector.h"

static inline void camera_spherical_ray(__constant const struct camera_spherical *camera, real u, real v,
                                        vector *anchor, vector *direction, real *start) {
    // A filter may leave the film: on around in longitude, and over a pole, where the sine turns negative.
    real sine, cosine, sin_theta, cos_theta, polar = 0.5f * v;
    sincos_turns(u - floor(u), &sine, &cosine);
    sincos_turns(polar - floor(polar), &sin_theta, &cos_theta);
    vector forward = vector_uniform(camera->forward), right = vector_uniform(camera->right), up = vector_uniform(camera->up);
    vector none = {0};
    vector around = vector_along(vector_along(none, -cosine, forward), -sine, right);
    *direction = vector_normalize(vector_along(vector_along(none, sin_theta, around), cos_theta, up));
    *anchor = vector_uniform(camera->origin);
    *start = (real)0.f;
}
