// Reflection without spreading, on both sides.
#include "core/gather.h"
#include "core/reflect.h"

static inline void material_mirror_sample(__global const float *numbers, integer at, vector in, vector shading,
                                          vector geometric, real u, real v, real w, vector *out, spectrum *weight, real *pdf) {
    vector n = reflect_normal(in, shading, geometric);
    *out = reflect_at(in, n);
    *weight = spectrum_gather(numbers, at);
    *pdf = (real)0.f;
}
