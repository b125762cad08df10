// Minima and maxima by operators (see lanes_vector.h). `b` where either is NaN.
static inline real smaller(real a, real b) { return pick(b, a, test(a < b)); }
static inline real larger(real a, real b) { return pick(b, a, test(a > b)); }
static inline integer clamp_index(integer i, int size) {
    integer last = (integer)(size - 1);
    i = pick(i, (integer)0, test(i < 0));
    return pick(i, last, test(i > last));
}
