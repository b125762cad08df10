// What depends on the precision of lanes: doubles. EPSILON is the largest relative error of one rounding;
// steps are no shorter than SMALLEST_STEP times where they begin.
#define EPSILON 0x1p-53
#define SMALLEST_STEP 0x1p-40

// A pair of floats holds 48 bits of the sum.
static inline void store_pair(real high, real low, __global float *film, size_t plane) {
    lanes_store_float(high + low, film);
    lanes_store_float((high - lanes_as_float(high + low)) + low, film + plane);
}
#define store_count(n, p) lanes_store_uint(n, p)
#define store_bits(x, p) lanes_store_uint(real_as_word(x), p)
