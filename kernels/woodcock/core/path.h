// The state of a lane's path. Positions lie in the volume's local space and are kept relative to the last collision:
// `origin` + `t` × `along`, so that small steps are never added to a large number. `t` is a length in the scene.
#include "core/rng.h"
#include "core/vector.h"

typedef struct {
    rng_address random;
    vector origin, along;  // last collision or entry; direction of the flight (or shadow walk) in local space
    vector direction;      // direction of travel in the scene
    real t, t_exit;        // along the flight; where it leaves the volume
    spectrum throughput, radiance;
} path;
