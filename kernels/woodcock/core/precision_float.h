// What depends on the precision of lanes: floats. EPSILON is the largest relative error of one rounding;
// steps are no shorter than SMALLEST_STEP times where they begin.
#define EPSILON 0x1p-24f
#define SMALLEST_STEP 0x1p-16f

static inline void store_pair(real high, real low, __global float *film, size_t plane) {
    lanes_store(high, film);
    lanes_store(low, film + plane);
}
#define store_count(n, p) lanes_store(integer_as_word(n), p)
#define store_bits(x, p) lanes_store(real_as_word(x), p)
