// A lobe in the versine from its peak's axis, m = 1 ∓ cos θ for g ≷ 0: the textbook forms divide by g and cancel near the
// peak, these do neither. gap = 1 - |g|, from the host.
#include "core/warp.h"

// p = (1 - g²) / 4π (1 + g² - 2 g cos θ)^(3/2), with 1 + g² - 2 g cos θ = gap² + 2 |g| m and m = |in ∓ out|² / 2.
static inline real lobe_henyey_greenstein_at(number g, number gap, vector in, vector out) {
    vector chord = vector_along(in, (real)-copysign((number)1.f, g), out);
    real squared = gap * gap + fabs(g) * vector_dot(chord, chord);
    return 0.0795774715f * gap * (1.f + fabs(g)) / (squared * sqrt(squared));
}

// The textbook inverse of the distribution function, solved for m = 2 gap² (1 - u) (1 + |g| u) / (gap + 2 |g| u)²; rest = 1 - u.
static inline vector lobe_henyey_greenstein_around(real g, real gap, vector in, real u, real rest, real v) {
    real side = copysign((real)1.f, g), size = fabs(g), ratio = gap / (gap + 2.f * size * u);
    real m = 2.f * ratio * ratio * rest * (1.f + size * u);
    return warp_around(vector_of(in.x * side, in.y * side, in.z * side), smaller(m, (real)2.f), v);
}
