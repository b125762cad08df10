// A thin lens: Potmesil & Chakravarty, "A Lens and Aperture Camera Model for Synthetic Image Generation", SIGGRAPH 1981.
// All rays of a film coordinate meet in the plane of focus. They are anchored as a pinhole's are (see perspective.h): the
// lens's disk appears on the plane of the anchors scaled by `spread` = 1 - (depth of that plane) / (focus distance), which
// is 0 where it is the plane of focus. `start` is where the lens lies on the ray, relative to the anchor.
#include "core/sincos.h"
#include "core/vector.h"

static inline void camera_thin_lens_ray(__constant const struct camera_thin_lens *camera, real u, real v, real lens_u, real lens_v,
                                        vector *anchor, vector *direction, real *start) {
    real sine, cosine, radius = sqrt(lens_u);
    sincos_turns(lens_v, &sine, &cosine);
    vector lens_right = vector_uniform(camera->lens_right), lens_up = vector_uniform(camera->lens_up), none = {0};
    vector lens = vector_along(vector_along(none, radius * cosine, lens_right), radius * sine, lens_up);
    vector right = vector_uniform(camera->right), down = vector_uniform(camera->down);
    vector on_film = vector_along(vector_along(none, u, right), v, down);
    vector film = vector_along(on_film, (real)1.f, vector_uniform(camera->corner));
    *anchor = vector_along(film, (real)camera->spread, lens);
    // From the lens to the anchor; by the corner as seen from the camera, not by positions, which would cancel.
    vector away = vector_along(on_film, (real)1.f, vector_uniform(camera->view));
    away = vector_along(away, (real)(camera->spread - 1.f), lens);
    real distance = sqrt(vector_dot(away, away));
    *direction = vector_of(away.x / distance, away.y / distance, away.z / distance);
    *start = -distance;
}
