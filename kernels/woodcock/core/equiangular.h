// Distances along a segment of a ray by equal angles seen from a point light, so that their density follows the light's
// 1 / distance²: Kulla & Fajardo, "Importance Sampling Techniques for Path Tracing in Participating Media", CGF 31(4), 2012.
// The direction is a unit vector, lengths are the device's, where a scene is of unit size. With a and b the segment's ends
// seen from the foot of the light's perpendicular and D its length,
//   t - near = (D² + a²) sin φ / (D cos φ - a sin φ), φ = u (θ_b - θ_a), tan(θ_b - θ_a) = D (b - a) / (D² + a b):
// the textbook's tangents by their addition theorems, which subtract nothing that is nearly equal where the light is far.
#include "core/angle.h"
#include "core/sincos.h"
#include "core/vector.h"

// A segment from near to far, seen from a light.
typedef struct { real near, far, a, D, angle; } equiangular;

static inline equiangular equiangular_pick(const equiangular *no, const equiangular *yes, mask chosen) {
    equiangular e = {pick(no->near, yes->near, chosen), pick(no->far, yes->far, chosen), pick(no->a, yes->a, chosen),
                     pick(no->D, yes->D, chosen), pick(no->angle, yes->angle, chosen)};
    return e;
}

static inline equiangular equiangular_of(vector origin, vector direction, vector light, real near, real far) {
    equiangular e;
    vector to = vector_along(light, (real)-1.f, origin);
    real foot = vector_dot(to, direction);
    vector apart = vector_along(to, -foot, direction);
    e.near = near;
    e.far = far;
    e.a = near - foot;
    real length = far - near, b = e.a + length, m = larger(fabs(e.a), fabs(b));
    // A light on the ray would draw every sample to itself; this far off it still leaves the segment's ends thousands of
    // the uniforms' 2^24 steps. A segment without end, or the light at its very end, does not count.
    real reach = smaller(m, larger(smaller(fabs(e.a), fabs(b)), (real)4.f));
    e.D = larger(sqrt(vector_dot(apart, apart)), 1e-4f * reach + 1e-12f);
    m = larger(m, e.D);
    e.angle = larger(angle_of(e.D * (length / m), e.D * (e.D / m) + e.a * (b / m)), (real)1e-35f);
    return e;
}

static inline real equiangular_sample(const equiangular *e, real u) {
    real sine, cosine, m = larger(fabs(e->a), e->D), a = e->a / m, D = e->D / m;
    sincos_turns(u * e->angle * 0.159154943f, &sine, &cosine);
    real step = m * ((D * D + a * a) * sine / larger(D * cosine - a * sine, (real)1e-30f));
    return smaller(e->near + step, e->far);
}

// The density per length at t; 0 outside the segment, and never more than 1e30.
static inline real equiangular_pdf(const equiangular *e, real t) {
    real ratio = (t - e->near + e->a) / e->D;
    real density = smaller(1.f / (e->D * e->angle * (1.f + ratio * ratio)), (real)1e30f);
    return pick((real)0.f, density, test(t >= e->near) & test(t <= e->far));
}
