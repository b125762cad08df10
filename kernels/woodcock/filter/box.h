// The mean over a square.
static inline real filter_box_offset(__constant const struct filter_box *filter, real u) {
    return (2.f * u - 1.f) * filter->radius;
}

static inline real filter_box_pdf(__constant const struct filter_box *filter, real offset) {
    return pick((real)0.f, (real)(0.5f / filter->radius), test(fabs(offset) <= filter->radius));
}
