// Transmittance of a homogeneous medium, exp(-σ_t s): the walk is over in one step.
static inline mask transmittance_exact_step(real *transmittance, real density, real length, real mean_free_path, mask escape, real u) {
    *transmittance = exp(-length / mean_free_path);
    return (mask)-1;
}
