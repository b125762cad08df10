// Light from a disk of one radiance in the sky, E / π sin² α with E the irradiance on a surface that faces its middle and
// α its angular radius. Sampled uniformly in solid angle. Angles are compared by their versines, 1 - cos, which keep the
// precision that cosines lose for small disks; they and all that follows from them come from the host, in float64.
#include "core/light_sample.h"
#include "core/warp.h"

static inline mask light_sun_covers(__constant const struct light_sun *light, vector direction) {
    vector chord = vector_along(direction, (real)-1.f, vector_uniform(light->towards));
    return test(0.5f * vector_dot(chord, chord) <= light->versine);
}

static inline spectrum light_sun_radiance(__constant const struct light_sun *light, vector direction) {
    return spectrum_pick(spectrum_grey((real)0.f), spectrum_uniform(light->radiance), light_sun_covers(light, direction));
}

static inline real light_sun_pdf(__constant const struct light_sun *light, vector direction) {
    return pick((real)0.f, (real)light->density, light_sun_covers(light, direction));
}

static inline void light_sun_sample(__constant const struct light_sun *light, vector from, real u, real v, light_sample *s) {
    s->towards = warp_around(vector_uniform(light->towards), u * light->versine, v);
    s->distance = (real)1e30f;
    s->weight = spectrum_uniform(light->weight);
    s->pdf = (real)light->density;
}
