// Flights of the small loop under a bound on σ_t for every cell. As flight_global.h, whose functions are the same:
// `_exit`, how far a ray from inside goes; `_start`, which sets out from the path's origin to leave the volume at `t_exit`;
// `_step`, on to the next tentative collision, which returns lanes that leave instead; `_density`, σ_t over the bound.
#include "core/path.h"
#include "majorant/grid.h"

typedef struct {
    majorant_walk walk;
    real free_path; // in the cell
} flight;

// The walk finds the exit by itself, from where its last cells end.
static inline real flight_exit(const struct world *world, const path *p) { return (real)1e30f; }

static inline void flight_start(flight *f, path *p, const struct world *world, mask chosen) {
    majorant_start(world, p->origin, p->along, p->t_exit, &f->walk, chosen);
    p->t_exit = f->walk.far;
}

static inline mask flight_step(flight *f, path *p, const struct world *world, real depth) {
    mask escape = majorant_step(world, &f->walk, depth);
    f->free_path = 1.f / f->walk.bound;
    p->t = f->walk.t;
    return escape;
}

static inline real flight_density(const flight *f, const struct world *world, vector at, words w) {
    return volume_density(world, at, w) * f->free_path;
}
