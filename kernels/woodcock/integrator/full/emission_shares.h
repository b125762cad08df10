// Emission is gathered by two estimators of one integral, each for a share of it: along every piece of a flight, ∫ ε, and
// where the flight collides, ε / σ_t (combined estimators: Halperin, "Almost linearly-optimum combination of unbiased
// estimates", JASA 56, 1961; X-5 Monte Carlo Team, MCNP manual, LA-UR-03-1987, 2003). The first has no noise in thin media,
// the second none in thick ones of one temperature, and where both have some it is opposite: a flight that goes far gathers
// more along its way and collides less. The share of collisions is σ_t / (σ_t + κ), a function of the place alone, so that
// nothing is divided by what may be 0. For a slab the best κ is about one per thickness; a fire gains as much from 3 to 8
// per size of the scene, which is the device's unit.
#define EMISSION_KAPPA 4.f

static inline spectrum emission_collided(spectrum epsilon, coefficient sigma_t) {
    coefficient share;
    for (int c = 0; c < COEFFICIENTS; ++c)
        coefficient_channel(share, c) = 1.f / (EMISSION_KAPPA + coefficient_channel(sigma_t, c));
    return spectrum_attenuate(epsilon, share);
}

static inline spectrum emission_along(spectrum epsilon, coefficient sigma_t) {
    return spectrum_scale(emission_collided(epsilon, sigma_t), (real)EMISSION_KAPPA);
}
