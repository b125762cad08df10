// Vectors and spectra from consecutive numbers of a buffer, from element `at` on.
#include "core/vector.h"

static inline vector vector_gather(__global const float *numbers, integer at) {
    return vector_of(gather(float, numbers, at), gather(float, numbers, at + 1), gather(float, numbers, at + 2));
}

static inline spectrum spectrum_gather(__global const float *numbers, integer at) {
    spectrum s;
    for (int c = 0; c < CHANNELS; ++c) spectrum_channel(s, c) = gather(float, numbers, at + c);
    return s;
}
