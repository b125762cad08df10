// Parallel light from infinitely far away. No sampled direction ever hits it, so next-event estimation is its only
// estimator; its density is a delta, so the weight is the irradiance itself.
#include "core/vector.h"

static inline vector light_directional_sample(__constant const struct light_directional *light, spectrum *weight) {
    *weight = spectrum_uniform(light->irradiance);
    return vector_uniform(light->towards);
}
