// A smooth boundary between two transparent materials: reflects with Fresnel's probability, else refracts. Radiance
// changes by the square of the relative index on its way through (Veach, "Non-symmetric scattering in light transport
// algorithms", EGWR 1996).
#include "core/gather.h"
#include "core/reflect.h"

static inline void material_dielectric_sample(__global const float *numbers, integer at, vector in, vector shading,
                                              vector geometric, real u, real v, real w, vector *out, spectrum *weight,
                                              real *pdf) {
    real ior = gather(float, numbers, at);
    vector n = reflect_normal(in, shading, geometric);
    real along = vector_dot(in, n), side = -copysign((real)1.f, along), cosine = fabs(along), refracted;
    real eta = pick(1.f / ior, ior, test(along < 0.f));
    mask reflects = test(w < reflect_fresnel(cosine, eta, &refracted));
    n = vector_of(side * n.x, side * n.y, side * n.z);
    *out = vector_pick(refract_at(in, n, eta, cosine, refracted), reflect_at(in, n), reflects);
    // Nothing that reflects may end behind the surface, and nothing that refracts before it.
    mask before = test(vector_dot(in, geometric) * vector_dot(*out, geometric) < 0.f);
    real value = pick(1.f / (eta * eta), (real)1.f, reflects);
    *weight = spectrum_grey(pick((real)0.f, value, (before & reflects) | (~before & ~reflects)));
    *pdf = (real)0.f;
}
