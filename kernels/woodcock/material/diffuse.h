// Lambert's law, on both sides: f = reflectance / π.
#include "core/frame.h"
#include "core/gather.h"
#include "core/sincos.h"

// Cosine of `out` with the normal that faces the ray; 0 where either normal sees the two rays on different sides.
static inline real material_diffuse_cosine(vector in, vector out, vector shading, vector geometric) {
    real cosine = -copysign((real)1.f, vector_dot(in, shading)) * vector_dot(out, shading);
    mask seen = test(vector_dot(in, geometric) * vector_dot(out, geometric) < 0.f) & test(cosine > 0.f);
    return pick((real)0.f, cosine, seen);
}

static inline void material_diffuse_eval(__global const float *numbers, integer at, vector in, vector out, vector shading,
                                         vector geometric, spectrum *value, real *pdf) {
    *pdf = 0.318309886f * material_diffuse_cosine(in, out, shading, geometric);
    *value = spectrum_scale(spectrum_gather(numbers, at), *pdf);
}

static inline void material_diffuse_sample(__global const float *numbers, integer at, vector in, vector shading,
                                           vector geometric, real u, real v, real w, vector *out, spectrum *weight, real *pdf) {
    real sine, cosine, side = -copysign((real)1.f, vector_dot(in, shading)), radius = sqrt(u);
    sincos_turns(v, &sine, &cosine);
    vector n = vector_of(side * shading.x, side * shading.y, side * shading.z);
    *out = frame_to_world(n, radius * cosine, radius * sine, sqrt(1.f - u));
    real seen = material_diffuse_cosine(in, *out, shading, geometric);
    *pdf = 0.318309886f * seen;
    *weight = spectrum_scale(spectrum_gather(numbers, at), pick((real)0.f, (real)1.f, test(seen > 0.f)));
}
