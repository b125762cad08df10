// Draine, "Scattering by interstellar dust grains", ApJ 598, 2003: Henyey–Greenstein × (1 + α cos² θ) / N,
// N = 1 + α (1 + 2 g²) / 3; α = 0 is Henyey & Greenstein, α = 1 Cornette & Shanks (1992), with g = 0 Rayleigh.
#include "phase/lobe_draine.h"

static inline real phase_draine_eval(__constant const struct phase_draine *phase, vector in, vector out) {
    return lobe_draine_at(phase->g, phase->gap, phase->base, phase->square, in, out);
}

static inline vector phase_draine_sample(__constant const struct phase_draine *phase, vector in, real u, real v) {
    return lobe_draine_around(phase->g, phase->gap, phase->base, phase->square, in, u, v);
}

static inline real phase_draine_pdf(__constant const struct phase_draine *phase, vector in, vector out) {
    return phase_draine_eval(phase, in, out);
}
