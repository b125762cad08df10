// Rayleigh scattering without depolarisation: p = 3 (1 + cos² θ) / 16π.
#include "core/warp.h"

static inline real phase_rayleigh_eval(__constant const struct phase_rayleigh *phase, vector in, vector out) {
    real cosine = vector_dot(in, out);
    return 0.0596831037f * (1.f + cosine * cosine);
}

// The share w that lies nearer to a pole than the versine m is m (6 - 3 m + m²) / 8. Cardano's root of it cancels where m is
// small; two of Newton's steps from m's series, which the denominator 3 (1 + (1 - m)²) keeps tame, do not.
static inline vector phase_rayleigh_sample(__constant const struct phase_rayleigh *phase, vector in, real u, real v) {
    mask backward = test(u < 0.5f);
    real w = pick(1.f - u, u, backward), side = pick((real)1.f, (real)-1.f, backward);
    real m = w * (1.33333333f + 0.888888889f * w * (1.f + w));
    for (int step = 0; step < 2; ++step) {
        real c = 1.f - m;
        m -= (m * (6.f - m * (3.f - m)) - 8.f * w) / (3.f + 3.f * c * c);
    }
    return warp_around(vector_of(in.x * side, in.y * side, in.z * side), m, v);
}

static inline real phase_rayleigh_pdf(__constant const struct phase_rayleigh *phase, vector in, vector out) {
    return phase_rayleigh_eval(phase, in, out);
}
