// Henyey & Greenstein, "Diffuse radiation in the galaxy", ApJ 93, 1941. Written in the versine from the axis of the peak,
// m = 1 ∓ cos θ for g ≷ 0: the textbook forms divide by g and cancel near the peak, these do neither.
// gap = 1 - |g|, computed in float64 on the host.
#include "core/warp.h"

// p = (1 - g²) / 4π (1 + g² - 2 g cos θ)^(3/2), with 1 + g² - 2 g cos θ = gap² + 2 |g| m and m = |in ∓ out|² / 2.
static inline real phase_henyey_greenstein_eval(__constant const struct phase_henyey_greenstein *phase, vector in, vector out) {
    vector chord = vector_along(in, (real)-copysign(1.f, phase->g), out);
    real squared = phase->gap * phase->gap + fabs(phase->g) * vector_dot(chord, chord);
    return 0.0795774715f * phase->gap * (1.f + fabs(phase->g)) / (squared * sqrt(squared));
}

// The textbook inverse of the distribution function, solved for m:
// m = 2 gap² (1 - u) (1 + |g| u) / (gap + 2 |g| u)².
static inline vector phase_henyey_greenstein_sample(__constant const struct phase_henyey_greenstein *phase, vector in,
                                                    real u, real v) {
    float side = copysign(1.f, phase->g), g = fabs(phase->g);
    real ratio = phase->gap / (phase->gap + 2.f * g * u);
    real m = 2.f * ratio * ratio * (1.f - u) * (1.f + g * u);
    vector axis = vector_of(in.x * side, in.y * side, in.z * side);
    return warp_around(axis, smaller(m, (real)2.f), v);
}

static inline real phase_henyey_greenstein_pdf(__constant const struct phase_henyey_greenstein *phase, vector in, vector out) {
    return phase_henyey_greenstein_eval(phase, in, out);
}
