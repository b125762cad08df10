// Optical depth, summed with what rounding leaves of it (Kahan 1965): a ray crosses thousands of cells.
typedef struct { coefficient sum, rest; } optical_depth;

static inline void optical_depth_add(optical_depth *depth, coefficient step) {
    for (int c = 0; c < COEFFICIENTS; ++c) {
        real sum = coefficient_channel(depth->sum, c);
        real y = coefficient_channel(step, c) + coefficient_channel(depth->rest, c), total = sum + y;
        coefficient_channel(depth->rest, c) = y - (total - sum);
        coefficient_channel(depth->sum, c) = total;
    }
}

// Lanes where something still gets through, in some channel.
static inline mask optical_depth_is_finite(const optical_depth *depth) {
    mask finite = (mask)0;
    for (int c = 0; c < COEFFICIENTS; ++c) finite |= test(exp(-coefficient_channel(depth->sum, c)) > 0.f);
    return finite;
}
