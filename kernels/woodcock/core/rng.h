// Random numbers are addressed, not drawn in order: (seed, pixel, sample, dimension) -> four words, a 128-bit address.
// So any range of samples can be rendered anywhere, in any order, again after a crash, and means the same.
typedef struct { word x, y, z, w; } words;

// pcg4d: Jarzynski & Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020.
static inline words pcg4d(words v) {
    v.x = v.x * 1664525u + 1013904223u;
    v.y = v.y * 1664525u + 1013904223u;
    v.z = v.z * 1664525u + 1013904223u;
    v.w = v.w * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v.x ^= v.x >> 16u;
    v.y ^= v.y >> 16u;
    v.z ^= v.z >> 16u;
    v.w ^= v.w >> 16u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// The address of a path; `dimension` counts the words taken along it, four at a time.
typedef struct { word pixel, sample, dimension; uint seed; } rng_address;

// The hash's low bits alone are biased (roulette on bit 0: by 0.8 %), so low halves are mixed with high ones.
static inline words rng_words(const rng_address *at, word dimension) {
    words v = {at->pixel, at->sample, dimension, (word)at->seed};
    v = pcg4d(v);
    v.x ^= v.x >> 16u;
    v.y ^= v.y >> 16u;
    v.z ^= v.z >> 16u;
    v.w ^= v.w >> 16u;
    return v;
}

// The next four words; the address moves on in the lanes that take them, so that no path depends on its neighbours.
static inline words rng_next(rng_address *at, mask taken) {
    words v = rng_words(at, at->dimension);
    at->dimension -= integer_as_word(taken);
    return v;
}

// Uniform in [0, 1), 24 bits.
static inline real unit(word w) { return to_real(word_as_integer(w >> 8u)) * 0x1p-24f; }

// Uniform in (0, 1], 40 bits: -log(u) follows the exponential law to 27 mean free paths. `low` gives the last 8 bits.
static inline real unit_positive(word high, word low) {
    return to_real(word_as_integer(high >> 8u)) * 0x1p-24f
         + (to_real(word_as_integer(((high & 255u) << 8u) | (low & 255u))) + 0.5f) * 0x1p-40f;
}

// Where the words above begin with 24 zeros, the uniforms go on from here with words of their own, so that tails and tiny
// probabilities keep a full exponent; a free flight reaches 34 mean free paths (exp(-34) = 2^-49).
static inline mask unit_is_deep(word w) { return test((w >> 8u) == 0u); }
static inline real unit_positive_deep(word w) { return (to_real(word_as_integer(w >> 8u)) + 0.5f) * 0x1p-48f; }
static inline real unit_deep(word w) { return unit(w) * 0x1p-24f; }
