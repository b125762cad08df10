// One bound on σ_t for the whole volume.
static inline real majorant_global_mean_free_path(__constant const struct majorant_global *majorant) {
    return (real)majorant->mean_free_path;
}
