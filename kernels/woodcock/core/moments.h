// Sum and sum of squares of a pixel's samples as unevaluated pairs of floats (about 48 bits): a range of samples gives
// the same numbers, to the rounding of a float64 sum, however it is cut. Two-sum: Knuth; fast two-sum: Dekker (1971).
typedef struct { real sum, sum_low, square, square_low; } moments;

// Adds x, and what rounding has left of it elsewhere, to a pair.
static inline void pair_add(real *high, real *low, real x, real rest) {
    real s = *high + x, b = s - *high;
    real error = ((*high - (s - b)) + (x - b)) + (*low + rest);
    *high = s + error;
    *low = error - (*high - s);
}

static inline void moments_add(moments *m, real x) {
    real square = x * x;
    pair_add(&m->sum, &m->sum_low, x, (real)0.f);
    pair_add(&m->square, &m->square_low, square, fma(x, x, -square));
}

// Four planes of one number a lane.
static inline void moments_store(const moments *m, __global float *film, size_t plane) {
    store_pair(m->sum, m->sum_low, film, plane);
    store_pair(m->square, m->square_low, film + 2 * plane, plane);
}
