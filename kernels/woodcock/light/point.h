// Light from one point into every direction alike: intensity / distance². No sampled direction ever hits the point, so
// next-event estimation is its only estimator.
#include "core/light_sample.h"

static inline void light_point_sample(__constant const struct light_point *light, vector from, real u, real v, light_sample *s) {
    vector to = vector_along(vector_uniform(light->position), (real)-1.f, from);
    // Kept from 0, so that a vertex in the light itself gets a finite weight.
    s->distance = sqrt(larger(vector_dot(to, to), (real)1e-24f));
    real inverse = 1.f / s->distance;
    s->towards = vector_of(to.x * inverse, to.y * inverse, to.z * inverse);
    s->weight = spectrum_scale(spectrum_uniform(light->intensity), inverse * inverse);
    s->pdf = (real)0.f;
}
