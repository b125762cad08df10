// Emissive surfaces as one light: a primitive by area × luminance, then a point on it. Shirley, Wang & Zimmerman, "Monte
// Carlo techniques for direct lighting calculations", ACM TOG 15(1), 1996; spheres by the cone that sees them.
// Probabilities are whole numbers of 2^-24, as the uniforms are, so that the density is exactly what is sampled.
#include "core/light_sample.h"

// Ends of the primitives' shares, padded to a power of two of which element 0 holds the half.
static inline integer surface_emitter(const struct world *world, real w) {
    __global const int *ends = world->surface_emitter_ends;
    integer share = to_integer(w * 0x1p24f), found = (integer)0;
    for (int step = ends[0]; step > 0; step >>= 1)
        found = pick(found, found + step, test(gather(int, ends, found + step) <= share));
    return found;
}

static inline void surface_light_sample(const struct world *world, vector from, real u, real v, real w, light_sample *s) {
    integer primitive = gather(int, world->surface_emitters, surface_emitter(world, w));
    surface_point point;
    real pdf = gather(float, world->surface_emitter_pdf, primitive)
             * surface_emit(world, primitive, from, u, v, &s->towards, &s->distance, &point);
    spectrum radiance = material_emission(world, point.surface, s->towards, point.geometric);
    // A shadow ray ends before the light, by more than rounding.
    s->distance = larger(s->distance * 0.99999f, (real)0.f);
    s->weight = spectrum_scale(radiance, 1.f / pdf);
    s->pdf = pdf;
}

// Density per solid angle with which the sampling above, from `from`, takes the direction of a ray that has hit `point`
// of the primitive; 0 where that does not shine.
static inline real surface_light_pdf(const struct world *world, integer primitive, vector from, surface_point point,
                                     vector direction) {
    integer asked = pick(primitive, (integer)0, test(primitive < 0));
    return gather(float, world->surface_emitter_pdf, asked) * surface_emit_pdf(world, asked, from, point, direction);
}
