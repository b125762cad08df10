// Transmittance by ratio tracking: Cramer, "Application of the fictitious scattering radiation transport model", NSE 65, 1978;
// Novák et al., "Residual ratio tracking", SIGGRAPH Asia 2014. Every tentative collision multiplies by 1 - σ_t / majorant.
// Faint walks play roulette, by what is left of the walk's own start: by the path's weight there would be a heavy tail.
#include "core/roulette.h"

static inline mask transmittance_ratio_step(real *transmittance, real density, real length, real mean_free_path, mask escape, real u) {
    real t = pick(*transmittance * (1.f - density), *transmittance, escape);
    real chance = roulette_chance(t);
    *transmittance = pick(t, pick((real)0.f, t / chance, test(u <= chance)), ~escape);
    return escape | test(*transmittance <= 0.f);
}
