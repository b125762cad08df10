// A weighted sum of phase functions. Which ones is the scene's matter: `phase/compose.py` writes the sum and the choice, one
// call a component, over these. Component i has the weight weight_i and is chosen by u in [start_i, start_i + weight_i).
#include "core/choice.h"

static inline mask phase_mixture_takes(real u, number start, number end) { return test(u >= start) & test(u < end); }

static inline real phase_mixture_rest(real u, number start, number weight) {
    return choice_stretch(u, (real)start, (real)weight);
}
