// Weights of a path where every σ_t is grey: distances have the same density in every channel, so all of it cancels but
// the albedo.
static inline void path_hero(path *p, mask begin) {}
static inline void path_null(path *p, coefficient sigma_t, real bound, mask null) {}
static inline void path_collide(path *p, coefficient sigma_t, spectrum albedo, mask collide) {
    p->throughput = spectrum_pick(p->throughput, spectrum_multiply(p->throughput, albedo), collide);
}
static inline void path_survive(path *p, const struct world *world, real t, mask flown) {}
static inline spectrum path_weight_at(const path *p, const struct world *world, real t) { return p->throughput; }
