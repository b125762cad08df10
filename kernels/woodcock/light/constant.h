// An environment of one radiance in every direction. A path that leaves the medium finds it with probability one, so it
// is collected on escape and casts no shadow rays.
#include "core/vector.h"

static inline spectrum light_constant_radiance(__constant const struct light_constant *light, vector direction) {
    return spectrum_uniform(light->radiance);
}
