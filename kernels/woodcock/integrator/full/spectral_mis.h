// Weights of a path where σ_t has colour, by spectral multiple importance sampling: Miller, Georgiev & Jarosz, "A null-scattering
// path integral formulation of light transport", SIGGRAPH 2019. One channel, the hero, samples all distances; `throughput`
// is the path's measurement over the mean of the densities by which the three heroes would have made it, and `balance`
// those densities over their mean. Both are normalised at every step, so that neither runs out of range: a weight is at
// most three times the best channel's, and dense coloured media have no fireflies.
// A pixel's samples take the channels in turn, from one that is the pixel's own.
static inline void path_hero(path *p, mask begin) {
    rng_address of_pixel = p->random;
    of_pixel.sample = (word)0u;
    integer hero = word_as_integer((rng_words(&of_pixel, (word)0x40000000u).x % 3u + p->random.sample % 3u) % 3u);
    p->hero = pick(p->hero, hero, begin);
    p->balance = coefficient_pick(p->balance, coefficient_grey((real)1.f), begin);
}

static inline void path_reweigh(path *p, spectrum measurement, coefficient density, mask chosen) {
    coefficient balance = coefficient_multiply(p->balance, density);
    real mean = coefficient_mean(balance), scale = pick((real)0.f, 1.f / mean, test(mean > 0.f));
    spectrum throughput = spectrum_scale(spectrum_multiply(p->throughput, measurement), scale);
    p->throughput = spectrum_pick(p->throughput, throughput, chosen);
    p->balance = coefficient_pick(p->balance, coefficient_scale(balance, scale), chosen);
}

static inline void path_null(path *p, coefficient sigma_t, real bound, mask null) {
    spectrum ratio;
    for (int c = 0; c < CHANNELS; ++c)
        spectrum_channel(ratio, c) = larger((real)0.f, 1.f - coefficient_channel(sigma_t, c) / bound);
    path_reweigh(p, ratio, ratio, null);
}

static inline void path_collide(path *p, coefficient sigma_t, spectrum albedo, mask collide) {
    coefficient relative = coefficient_scale(sigma_t, 1.f / coefficient_max(sigma_t));
    path_reweigh(p, spectrum_multiply(albedo, relative), relative, collide);
}

// exp(-τ) of the constant media up to t, relative to the channel that loses least.
static inline coefficient path_survival(const path *p, const struct world *world, real t) {
    coefficient depth = clocks_depth(world, p, t);
    real least = smaller(coefficient_channel(depth, 0), smaller(coefficient_channel(depth, 1), coefficient_channel(depth, 2)));
    for (int c = 0; c < CHANNELS; ++c) coefficient_channel(depth, c) -= least;
    return coefficient_exp_minus(depth);
}

static inline void path_survive(path *p, const struct world *world, real t, mask flown) {
    coefficient survival = path_survival(p, world, t);
    path_reweigh(p, survival, survival, flown);
}

// The path's weight at a point of the segment that it has not come to yet.
static inline spectrum path_weight_at(const path *p, const struct world *world, real t) {
    coefficient survival = path_survival(p, world, t), balance = coefficient_multiply(p->balance, survival);
    return spectrum_scale(spectrum_multiply(p->throughput, survival), 1.f / coefficient_mean(balance));
}
