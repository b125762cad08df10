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

// Narrows a segment to where it runs through the cone; near > far where it does not. With x = q + t d from the tip, it is in the
// cone where a·x >= 0 and (a·x)² >= cos² x², a quadratic in t.
static inline void light_spot_span(__constant const struct light_spot *light, vector origin, vector direction, real *near, real *far) {
    vector axis = vector_uniform(light->axis), q = vector_along(origin, (real)-1.f, vector_uniform(light->position));
    real cosine = (real)(1.f - light->cutoff), squared = cosine * cosine;
    real height = vector_dot(axis, q), along = vector_dot(axis, direction);
    real a = along * along - squared, b = height * along - squared * vector_dot(q, direction);
    real c = height * height - squared * vector_dot(q, q), discriminant = b * b - a * c;
    real k = -b - copysign(sqrt(larger(discriminant, (real)0.f)), b), one = k / a, other = c / k;
    real low = smaller(one, other), high = larger(one, other);
    // Flat rays are inside between the roots, if that is before the tip; steep ones beyond the one that lies there.
    mask flat = test(a < 0.f), ahead = test(along > 0.f);
    mask missed = flat & (test(discriminant < 0.f) | test(height + along * 0.5f * (low + high) < 0.f));
    *near = pick(*near, larger(*near, pick(high, low, flat)), flat | ahead);
    *far = pick(*far, smaller(*far, pick(low, high, flat)), flat | ~ahead);
    *far = pick(*far, *near - 1.f, missed);
}
