// Light from one point into a cone: intensity × smoothstep / distance², where the smoothstep rises in the cosine of the
// angle to the axis, from 0 at the cutoff to 1 at the beam. Cosines are kept as versines, 1 - cos, which tell small angles
// apart. No sampled direction ever hits the point, so next-event estimation is its only estimator.
#include "core/light_sample.h"

static inline real light_spot_falloff(__constant const struct light_spot *light, vector away) {
    vector chord = vector_along(away, (real)-1.f, vector_uniform(light->axis));
    real rise = (light->cutoff - 0.5f * vector_dot(chord, chord)) * light->steepness;
    rise = smaller(larger(rise, (real)0.f), (real)1.f);
    return rise * rise * (3.f - 2.f * rise);
}

static inline void light_spot_sample(__constant const struct light_spot *light, vector from, real u, real v, light_sample *s) {
    vector to = vector_along(vector_uniform(light->position), (real)-1.f, from);
    // Kept from 0, so that a vertex in the light itself gets a finite weight.
    s->distance = sqrt(larger(vector_dot(to, to), (real)1e-24f));
    real inverse = 1.f / s->distance;
    s->towards = vector_of(to.x * inverse, to.y * inverse, to.z * inverse);
    vector away = vector_of(-s->towards.x, -s->towards.y, -s->towards.z);
    s->weight = spectrum_scale(spectrum_uniform(light->intensity), light_spot_falloff(light, away) * inverse * inverse);
    s->pdf = (real)0.f;
}
