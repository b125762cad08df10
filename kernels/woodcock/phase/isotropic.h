// Isotropic scattering: p = 1 / 4π.
#include "core/sincos.h"
#include "core/vector.h"

static inline real phase_isotropic_eval(__constant const struct phase_isotropic *phase, vector in, vector out) {
    return (real)0.0795774715f;
}

static inline vector phase_isotropic_sample(__constant const struct phase_isotropic *phase, vector in, real u, real v) {
    real sine, cosine, z = 1.f - 2.f * u, radius = 2.f * sqrt(u * (1.f - u));
    sincos_turns(v, &sine, &cosine);
    return vector_of(radius * cosine, radius * sine, z);
}

static inline real phase_isotropic_pdf(__constant const struct phase_isotropic *phase, vector in, vector out) {
    return phase_isotropic_eval(phase, in, out);
}
