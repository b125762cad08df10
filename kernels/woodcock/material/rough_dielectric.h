// A rough boundary between two transparent materials: Walter et al., "Microfacet Models for Refraction through Rough
// Surfaces", EGSR 2007, with GGX and its separable shadowing, sampled by visible normals: Heitz, "Sampling the GGX
// Distribution of Visible Normals", JCGT 7(4), 2018. Light that meets the surface's facets more than once is lost: with
// ior 1.5 and a roughness of .1 and .5, .1 and 3 per cent of what falls on it straight, .8 and 12 at 60 degrees.
#include "core/frame.h"
#include "core/gather.h"
#include "core/reflect.h"
#include "core/sincos.h"

// D(h), per steradian. The sine comes from the part across the normal, which keeps narrow peaks exact.
static inline real material_rough_dielectric_density(vector n, vector h, real alpha) {
    real cosine = vector_dot(n, h);
    vector across = vector_along(h, -cosine, n);
    real spread = vector_dot(across, across) / alpha + alpha * cosine * cosine;
    return 0.318309886f / (spread * spread);
}

// Smith's masking G1 of a direction with this cosine to the normal.
static inline real material_rough_dielectric_masking(real cosine, real alpha) {
    real squared = cosine * cosine, wide = alpha * alpha * (1.f - smaller(squared, (real)1.f));
    return 2.f * cosine / (cosine + sqrt(squared + wide));
}

// f |cos| and density of `out` by the facet h, which faces the ray, as do n and `view`, from where the ray comes.
static inline void material_rough_dielectric_facet(vector view, vector out, vector n, vector h, real eta, real alpha,
                                                   mask reflects, real *value, real *pdf) {
    real cosine = vector_dot(view, n), seen = vector_dot(view, h), left = vector_dot(out, h), refracted;
    real fresnel = reflect_fresnel(seen, eta, &refracted);
    // Density of visible normals, G1 (view · h) D / (view · n), times how densely h turns into out.
    real visible = material_rough_dielectric_masking(cosine, alpha) * material_rough_dielectric_density(n, h, alpha) / cosine;
    real bend = seen + eta * left;
    real turn = pick(seen * fabs(left) * (1.f - fresnel) / (bend * bend), 0.25f * fresnel, reflects);
    *value = visible * turn * material_rough_dielectric_masking(fabs(vector_dot(out, n)), alpha);
    // Refraction is eta² as dense as light that comes back is bright.
    *pdf = visible * turn * pick(eta * eta, (real)1.f, reflects);
}

static inline void material_rough_dielectric_eval(__global const float *numbers, integer at, vector in, vector out,
                                                  vector shading, vector geometric, spectrum *value, real *pdf) {
    real ior = gather(float, numbers, at), alpha = gather(float, numbers, at + 1);
    real along = vector_dot(in, shading), side = -copysign((real)1.f, along);
    real eta = pick(1.f / ior, ior, test(along < 0.f));
    vector n = vector_of(side * shading.x, side * shading.y, side * shading.z), view = vector_of(-in.x, -in.y, -in.z);
    mask reflects = test(vector_dot(out, n) > 0.f), before = test(vector_dot(in, geometric) * vector_dot(out, geometric) < 0.f);
    real weight = pick(eta, (real)1.f, reflects);
    vector h = vector_normalize(vector_along(view, weight, out));
    real turn = copysign((real)1.f, vector_dot(h, n));
    h = vector_of(turn * h.x, turn * h.y, turn * h.z);
    real seen = vector_dot(view, h), left = vector_dot(out, h), f, density;
    // A facet is seen from its front; light leaves on the same side of it, or the other, as of the surface.
    mask possible = test(seen > 0.f) & ((reflects & before & test(left > 0.f)) | (~reflects & ~before & test(left < 0.f)));
    material_rough_dielectric_facet(view, out, n, h, eta, alpha, reflects, &f, &density);
    *value = spectrum_grey(pick((real)0.f, f, possible));
    *pdf = pick((real)0.f, density, possible);
}

static inline void material_rough_dielectric_sample(__global const float *numbers, integer at, vector in, vector shading,
                                                    vector geometric, real u, real v, real w, vector *out,
                                                    spectrum *weight, real *pdf) {
    real ior = gather(float, numbers, at), alpha = gather(float, numbers, at + 1);
    real along = vector_dot(in, shading), side = -copysign((real)1.f, along);
    real eta = pick(1.f / ior, ior, test(along < 0.f));
    vector n = vector_of(side * shading.x, side * shading.y, side * shading.z), view = vector_of(-in.x, -in.y, -in.z);
    vector s = frame_to_world(n, (real)1.f, (real)0.f, (real)0.f), t = frame_to_world(n, (real)0.f, (real)1.f, (real)0.f);

    // Facets stretched to a hemisphere, of which the view sees a disk and a part of it below the horizon.
    vector to = vector_normalize(vector_of(alpha * vector_dot(view, s), alpha * vector_dot(view, t), fabs(along)));
    real sine, cosine, radius = sqrt(u);
    sincos_turns(v, &sine, &cosine);
    real x = radius * cosine, y = radius * sine, lower = 0.5f * (1.f + to.z);
    y = (1.f - lower) * sqrt(larger(1.f - x * x, (real)0.f)) + lower * y;
    real z = sqrt(larger(1.f - x * x - y * y, (real)0.f));
    vector facet = vector_of(z * to.x, z * to.y, z * to.z);
    // The disk's axes: one across the view and the normal, the other up from the view towards the normal.
    real level = to.x * to.x + to.y * to.y, scale = 1.f / sqrt(larger(level, (real)1e-30f));
    mask upright = test(level < 1e-20f);
    vector first = vector_of(pick(-to.y * scale, (real)1.f, upright), pick(to.x * scale, (real)0.f, upright), (real)0.f);
    vector second = vector_of(-to.z * first.y, to.z * first.x, to.x * first.y - to.y * first.x);
    facet = vector_along(vector_along(facet, x, first), y, second);
    vector h = vector_normalize(vector_along(vector_of(alpha * facet.x * s.x + alpha * facet.y * t.x,
                                                       alpha * facet.x * s.y + alpha * facet.y * t.y,
                                                       alpha * facet.x * s.z + alpha * facet.y * t.z),
                                             larger(facet.z, (real)1e-6f), n));

    real seen = vector_dot(view, h), refracted;
    mask reflects = test(w < reflect_fresnel(seen, eta, &refracted));
    *out = vector_pick(refract_at(in, h, eta, seen, refracted), reflect_at(in, h), reflects);
    mask above = test(vector_dot(*out, n) > 0.f), before = test(vector_dot(in, geometric) * vector_dot(*out, geometric) < 0.f);
    mask possible = test(seen > 0.f) & ((reflects & above & before) | (~reflects & ~above & ~before));
    real masking = material_rough_dielectric_masking(fabs(vector_dot(*out, n)), alpha), f, density;
    material_rough_dielectric_facet(view, *out, n, h, eta, alpha, reflects, &f, &density);
    *weight = spectrum_grey(pick((real)0.f, masking * pick(1.f / (eta * eta), (real)1.f, reflects), possible));
    *pdf = pick((real)0.f, density, possible);
}
