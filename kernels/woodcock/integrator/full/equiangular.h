// Equiangular sampling of the distance along a flight: Kulla & Fajardo, "Importance sampling techniques for path tracing in
// participating media", EGSR 2012. Beside the collision that the flight itself makes, a vertex close to a point light is
// chosen in media that are constant, where its transmittance is known; the two share the light's samples by the power heuristic
// (Veach & Guibas 1995): in thin media collisions are rare, and what they would bring is noise. Densities are those of grey
// media; in colour they are means over channels, which weigh as rightly.
#include "core/equiangular.h"

// Density by which flights and next-event estimation make a vertex at t with the sample of this light.
static inline real equiangular_rival(const path *p, const struct world *world, real t, coefficient sigma_t) {
    coefficient survival = coefficient_exp_minus(clocks_depth(world, p, t));
    return coefficient_mean(coefficient_multiply(sigma_t, survival)) * LIGHT_CHANCE;
}

// The weight of the one that has the density `own`, above 0; a ratio, as squares of densities may not be floats.
static inline real equiangular_power(real own, real other) {
    real ratio = other / own;
    return 1.f / (1.f + ratio * ratio);
}

// The part of the segment that runs through constant media and that the light reaches, seen from it.
static inline equiangular equiangular_seen(const path *p, const struct world *world, integer light) {
    real near, far;
    clocks_span(world, p, &near, &far);
    light_place_span(world, light, p->origin, p->direction, &near, &far);
    return equiangular_of(p->origin, p->direction, light_place(world, light), near, far);
}

// The share of a collision at the segment's end; 1 for light that comes from no point.
static inline real equiangular_weight(const path *p, const struct world *world, integer light, mask vertex) {
    mask place = vertex & test(light >= 0);
    if (!some(place)) return (real)1.f;
    integer medium;
    coefficient own, sigma_t = clocks_sigma_t(world, p, p->end, (real)0.f, &medium, &own);
    real rival = equiangular_rival(p, world, p->end, sigma_t);
    equiangular seen = p->seen;
    // The segment has asked one light: of several, perhaps another one.
    if (some(place & test((real)PLACE_CHANCE < 1.f))) seen = equiangular_seen(p, world, light);
    real density = equiangular_pdf(&seen, p->end) * PLACE_CHANCE;
    return pick((real)1.f, equiangular_power(rival, density), place & test(rival > 0.f));
}

// Asks a light for flights that set out, from a vertex of their segment; returns those that wait for the answer.
static inline mask equiangular_start(path *p, const struct world *world, mask flying) {
    mask chosen = flying & ~p->asked;
    if (!some(chosen)) return (mask)0;
    p->asked |= chosen;
    words w = rng_next(&p->random, chosen);
    integer light = to_integer(unit(w.x) / PLACE_CHANCE);
    equiangular seen = equiangular_seen(p, world, light);
    p->seen = equiangular_pick(&p->seen, &seen, chosen);
    real t = equiangular_sample(&seen, unit(w.y));
    integer medium;
    coefficient own, sigma_t = clocks_sigma_t(world, p, t, unit(w.z), &medium, &own);
    vector at = vector_along(p->origin, t, p->direction);
    light_sample sample;
    light_place_sample(world, light, at, &sample);
    real rival = equiangular_rival(p, world, t, sigma_t), density = equiangular_pdf(&seen, t) * PLACE_CHANCE;
    real phase = phase_eval(world, medium, p->direction, sample.towards);
    coefficient survival = coefficient_exp_minus(clocks_depth(world, p, t));
    spectrum scattered = spectrum_attenuate(p->throughput, coefficient_multiply(own, survival));
    scattered = spectrum_multiply(scattered, media_albedo(world, medium, at, w));
    spectrum arriving = spectrum_scale(spectrum_multiply(scattered, sample.weight), phase / density * equiangular_power(density, rival));
    mask lit = chosen & test(seen.near < seen.far) & test(medium >= 0) & test(density > 0.f) & test(spectrum_max(arriving) > 0.f);
    return shadow_cast_aside(p, world, at, &sample, arriving, lit);
}
