// Flights of the small loop under one bound on σ_t.
#include "core/box.h"
#include "core/path.h"
typedef struct { int unused; } flight;

static inline real flight_exit(const struct world *world, const path *p) {
    return box_exit(volume_size(world), p->origin, p->along);
}
static inline void flight_start(flight *f, path *p, const struct world *world, mask chosen) {
    p->t = pick(p->t, (real)0.f, chosen);
    p->t_low = pick(p->t_low, (real)0.f, chosen);
}
static inline mask flight_step(flight *f, path *p, const struct world *world, real depth) {
    path_advance(p, depth * majorant_mean_free_path(world));
    return test(p->t >= p->t_exit);
}
static inline real flight_density(const flight *f, const struct world *world, vector at, words w) {
    return volume_density(world, at, w);
}
