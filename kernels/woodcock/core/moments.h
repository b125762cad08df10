// Sum and sum of squares of a pixel's samples as unevaluated pairs of floats (about 48 bits): a range of samples gives
// the same numbers, to float64 rounding on the host, however it is cut. Two-sum: Knuth; two-product by fma.
typedef struct { real sum, sum_low, square, square_low; } moments;

static inline void two_sum(real *high, real *low, real x) {
    real s = *high + x, b = s - *high;
    *low += (*high - (s - b)) + (x - b);
    *high = s;
}

static inline void moments_add(moments *m, real x) {
    real square = x * x;
    two_sum(&m->sum, &m->sum_low, x);
    two_sum(&m->square, &m->square_low, square);
    m->square_low += fma(x, x, -square);
}
