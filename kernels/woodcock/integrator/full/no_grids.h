// A scene without grids: segments end at once.
#include "core/audit.h"

typedef struct { int unused; } grid_state;
static inline void grids_start(path *p, const struct world *world, grid_state *walk, mask fresh) {
    p->tracked = pick(p->tracked, (real)0.f, fresh);
    p->tracked_low = pick(p->tracked_low, (real)0.f, fresh);
}
static inline void grids_step(path *p, const struct world *world, grid_state *walk, audit *found, mask *collided,
                              mask *lost) {
    *collided = *lost = (mask)0;
}
