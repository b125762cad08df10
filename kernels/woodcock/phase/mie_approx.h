// Water droplets: Jendersie & d'Eon, "An Approximate Mie Scattering Function for Fog and Cloud Rendering", SIGGRAPH 2023
// Talks: a Henyey–Greenstein lobe for the diffraction peak, a Draine lobe, the share `draine`, for the rest.
#include "core/choice.h"
#include "phase/lobe_draine.h"

static inline real phase_mie_approx_eval(__constant const struct phase_mie_approx *phase, vector in, vector out) {
    return phase->peak * lobe_henyey_greenstein_at(phase->peak_g, phase->peak_gap, in, out) +
           phase->draine * lobe_draine_at(phase->g, phase->gap, phase->base, phase->square, in, out);
}

static inline vector phase_mie_approx_sample(__constant const struct phase_mie_approx *phase, vector in, real u, real v) {
    mask peak = test(u >= phase->draine);
    real start = pick((real)0.f, (real)phase->draine, peak);
    real rest = choice_stretch(u, start, pick((real)phase->draine, (real)phase->peak, peak));
    vector out = in;
    if (some(~peak)) out = lobe_draine_around(phase->g, phase->gap, phase->base, phase->square, in, rest, v);
    if (some(peak)) {
        vector other =
            lobe_henyey_greenstein_around((real)phase->peak_g, (real)phase->peak_gap, in, rest, 1.f - rest, v);
        out = vector_pick(out, other, peak);
    }
    return out;
}

static inline real phase_mie_approx_pdf(__constant const struct phase_mie_approx *phase, vector in, vector out) {
    return phase_mie_approx_eval(phase, in, out);
}
