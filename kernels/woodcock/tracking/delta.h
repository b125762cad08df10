// Free flight by delta tracking: E. R. Woodcock et al., "Techniques used in the GEM code", ANL-7050, 1965.
// A tentative collision is real with probability σ_t / majorant, and null otherwise.
static inline mask free_flight_delta_collides(real density, real u) { return test(u < density); }
