// Even places in place of random ones: the R sequence, of any number of dimensions (Roberts, "The Unreasonable
// Effectiveness of Quasirandom Sequences", 2018). A coordinate in [0, 1) of a sample; sample 0 is the middle. `step` is the
// dimension's step as a fraction of 2^32, so that the sum wraps and rounds nothing at any sample.
static inline real sequence_at(uint sample, uint step) {
    return (real)((number)((0x80000000u + sample * step) >> 8u) * 0x1p-24f);
}
