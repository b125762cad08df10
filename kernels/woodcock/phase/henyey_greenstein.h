// Henyey & Greenstein, "Diffuse radiation in the galaxy", ApJ 93, 1941.
#include "phase/lobe_henyey_greenstein.h"

static inline real phase_henyey_greenstein_eval(__constant const struct phase_henyey_greenstein *phase, vector in, vector out) {
    return lobe_henyey_greenstein_at(phase->g, phase->gap, in, out);
}

static inline vector phase_henyey_greenstein_sample(__constant const struct phase_henyey_greenstein *phase, vector in,
                                                    real u, real v) {
    return lobe_henyey_greenstein_around((real)phase->g, (real)phase->gap, in, u, 1.f - u, v);
}

static inline real phase_henyey_greenstein_pdf(__constant const struct phase_henyey_greenstein *phase, vector in, vector out) {
    return phase_henyey_greenstein_eval(phase, in, out);
}
