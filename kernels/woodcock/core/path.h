// The state of a lane's path. Positions lie in the volume's local space and are kept relative to the last collision:
// `origin` + `t` × `along`, so that small steps are never added to a large number. `t` is a length in the scene.
#include "core/rng.h"
#include "core/vector.h"

typedef struct {
    rng_address random;
    vector origin, along;  // last collision or entry; direction of the flight (or shadow walk) in local space
    vector direction;      // direction of travel in the scene
    real t, t_low, t_exit; // along the flight, and what rounding left of it; where it leaves the volume
    spectrum throughput, radiance;
    integer order;         // scatterings so far
} path;

// Adds a step to t, compensated (Kahan 1965): t += step stalls for ever once the step is below half an ulp of t.
static inline void path_advance(path *p, real step) {
    real y = step + p->t_low, t = p->t + y;
    p->t_low = y - (t - p->t);
    p->t = t;
}
