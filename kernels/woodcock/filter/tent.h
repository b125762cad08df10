// Falls linearly from the pixel's middle. The inverse of the distribution function, from whichever end is nearer, so that
// nothing cancels there.
static inline real filter_tent_offset(__constant const struct filter_tent *filter, real u) {
    mask left = test(u < 0.5f);
    real gap = 1.f - sqrt(2.f * pick(1.f - u, u, left));
    return pick(gap, -gap, left) * filter->radius;
}

static inline real filter_tent_pdf(__constant const struct filter_tent *filter, real offset) {
    return larger(1.f - fabs(offset) / filter->radius, (real)0.f) / filter->radius;
}
