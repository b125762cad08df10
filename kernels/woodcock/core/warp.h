#include "core/frame.h"
#include "core/sincos.h"

// The unit vector at an angle to `axis` given by its versine, 1 - cos θ, which keeps the precision that cos θ loses
// near 1, turned by `azimuth` full turns. Normalised, so that long paths do not drift.
static inline vector warp_around(vector axis, real versine, real azimuth) {
    real sine, cosine, radius = sqrt(versine * (2.f - versine));
    sincos_turns(azimuth, &sine, &cosine);
    return vector_normalize(frame_to_world(axis, radius * cosine, radius * sine, 1.f - versine));
}
