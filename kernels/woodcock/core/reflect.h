// Reflection and refraction at a boundary: the laws of Snell and Fresnel for unpolarised light.
#include "core/vector.h"

static inline vector reflect_at(vector in, vector n) { return vector_along(in, -2.f * vector_dot(in, n), n); }

// The shading normal, or the geometric one where a reflection at the former would go through the surface.
static inline vector reflect_normal(vector in, vector shading, vector geometric) {
    real before = vector_dot(in, geometric), after = vector_dot(reflect_at(in, shading), geometric);
    return vector_pick(geometric, shading, test(before * after < 0.f));
}

// Reflectance at the cosine of incidence, 0 or more, where eta is the index behind the boundary over the one before it;
// the cosine of refraction, 0 where reflection is total. eta² - 1 is taken as a product, so that indices close to each
// other do not cancel.
static inline real reflect_fresnel(real cosine, real eta, real *refracted) {
    cosine = larger(cosine, (real)1e-7f);
    real squared = (eta - 1.f) * (eta + 1.f) + cosine * cosine;
    mask total = test(squared <= 0.f);
    real t = sqrt(larger(squared, (real)0.f)) / eta;
    real s = (cosine - eta * t) / (cosine + eta * t), p = (eta * cosine - t) / (eta * cosine + t);
    *refracted = t;
    return pick(0.5f * (s * s + p * p), (real)1.f, total);
}

// Direction behind the boundary; n faces the ray.
static inline vector refract_at(vector in, vector n, real eta, real cosine, real refracted) {
    real s = 1.f / eta, along = cosine * s - refracted;
    return vector_normalize(vector_of(s * in.x + along * n.x, s * in.y + along * n.y, s * in.z + along * n.z));
}
