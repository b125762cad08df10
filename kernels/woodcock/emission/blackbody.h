// Planck's radiance B of a temperature, from a table (blackbody.py) that is even in the inverse temperature, in which it
// falls as exp(-c / T): so linear interpolation is right to 1e-4 from the hottest voxel down to where nothing is left.
static inline spectrum emission_blackbody_radiance(__constant const struct emission_blackbody *emission, __global const float *table,
                                                   real value) {
    // T as a part of the largest; what is colder than the table's end gives its last entry, 0.
    real part = larger(value * emission->relative, (real)emission->coldest);
    real place = larger((1.f / part - 1.f) * emission->per_entry, (real)0.f);
    integer entry = clamp_index(to_integer(place), emission->entries - 1) * CHANNELS;
    real next = smaller(place - floor(place), (real)1.f);
    spectrum radiance;
    for (int c = 0; c < CHANNELS; ++c) {
        real a = to_real(gather(float, table, entry + c)), b = to_real(gather(float, table, entry + CHANNELS + c));
        spectrum_channel(radiance, c) = a + next * (b - a);
    }
    return radiance;
}
