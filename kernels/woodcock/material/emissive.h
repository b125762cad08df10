// Shines on the normal's side, or on both, and reflects nothing. Its numbers: radiance, then whether on both.
#include "core/gather.h"

static inline spectrum material_emissive_radiance(__global const float *numbers, integer at, vector in, vector geometric) {
    mask shines = test(vector_dot(in, geometric) < 0.f) | test(gather(float, numbers, at + CHANNELS) > 0.f);
    return spectrum_scale(spectrum_gather(numbers, at), pick((real)0.f, (real)1.f, shines));
}

static inline void material_emissive_sample(__global const float *numbers, integer at, vector in, vector shading,
                                            vector geometric, real u, real v, real w, vector *out, spectrum *weight, real *pdf) {
    *out = in;
    *weight = spectrum_grey((real)0.f);
    *pdf = (real)0.f;
}
