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
    words v = {at->pixel, at->sample, (word)at->seed, dimension};
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

// Uniform in (0, 1], 31 bits, of which a real keeps 24 significant ones: small values are as precise as large ones.
static inline real unit_fine(word w) { return (to_real(word_as_integer(w >> 1u)) + 0.5f) * 0x1p-31f; }

// Below 2^-13 the bits go on with those of a word of its own, down to 2^-64.
static inline mask unit_is_small(word w) { return test((w >> 19u) == 0u); }
static inline real unit_small(word w, word deep) { return (to_real(word_as_integer(w >> 1u)) + unit_fine(deep)) * 0x1p-31f; }

// A free flight, in mean free paths: the exponential law to 44 of them, and as precise for short ones. `u` is a uniform
// of its own, for the choice at the flight's end; it is as precise for tiny probabilities.
static inline real rng_flight(const rng_address *at, words w, real *u) {
    real depth = -log(unit_fine(w.x));
    *u = unit_fine(w.w);
    mask long_or_short = unit_is_small(w.x + 0x40000u), choice = unit_is_small(w.w);
    if (some(long_or_short | choice)) {
        // No step has this address: dimensions stay below 2^31. (One high bit would not do: pcg4d hardly spreads it.)
        words deep = rng_words(at, ~at->dimension);
        real high = unit_small(w.x, deep.x), low = unit_small(~w.x, deep.x);
        // -log(1 - low), to low^2 / 3.
        real tail = pick(low + 0.5f * low * low, -log(high), test((w.x >> 31u) == 0u));
        depth = pick(depth, tail, long_or_short);
        *u = pick(*u, unit_small(w.w, deep.w), choice);
    }
    return depth;
}
