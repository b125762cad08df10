// Transmittance by ratio tracking: Cramer, "Application of the fictitious scattering radiation transport model", NSE 65, 1978;
// Novák et al., "Residual ratio tracking", SIGGRAPH Asia 2014. Every tentative collision multiplies by 1 - σ_t / majorant.
// Below a twentieth the walk survives with probability 1/2; the threshold is relative to the walk's own start, because
// an absolute one on the path's weight gives a heavy tail.
static inline mask transmittance_ratio_step(real *transmittance, real density, real length, real mean_free_path, mask escape, real u) {
    real t = pick(*transmittance * (1.f - density), *transmittance, escape);
    mask faint = test(t < 0.05f) & ~escape;
    *transmittance = pick(t, pick((real)0.f, t * 2.f, test(u < 0.5f)), faint);
    return escape | test(*transmittance <= 0.f);
}
