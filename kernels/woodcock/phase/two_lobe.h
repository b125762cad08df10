// Two Henyey–Greenstein lobes: the share `first` of g1, the rest, `second`, of g2. Lanes choose their lobe's numbers, then
// sample once.
#include "core/choice.h"
#include "phase/lobe_henyey_greenstein.h"

static inline real phase_two_lobe_eval(__constant const struct phase_two_lobe *phase, vector in, vector out) {
    return phase->first * lobe_henyey_greenstein_at(phase->g1, phase->gap1, in, out) +
           phase->second * lobe_henyey_greenstein_at(phase->g2, phase->gap2, in, out);
}

static inline vector phase_two_lobe_sample(__constant const struct phase_two_lobe *phase, vector in, real u, real v) {
    mask first = test(u < phase->first);
    real start = pick((real)phase->first, (real)0.f, first);
    real rest = choice_stretch(u, start, pick((real)phase->second, (real)phase->first, first));
    real g = pick((real)phase->g2, (real)phase->g1, first), gap = pick((real)phase->gap2, (real)phase->gap1, first);
    return lobe_henyey_greenstein_around(g, gap, in, rest, 1.f - rest, v);
}

static inline real phase_two_lobe_pdf(__constant const struct phase_two_lobe *phase, vector in, vector out) {
    return phase_two_lobe_eval(phase, in, out);
}
