// One uniform for two uses: what [start, start + share) of it chose is stretched to [0, 1) again. Lanes that chose otherwise
// get one of the ends, so that what they compute in vain stays finite.
static inline real choice_stretch(real u, real start, real share) {
    return smaller(larger((u - start) / share, (real)0.f), (real)0x1.fffffep-1f);
}
