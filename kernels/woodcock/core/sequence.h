// Even places in place of random ones, in up to four dimensions: Sobol's points (Joe & Kuo's directions, 2008),
// scrambled as Owen does ("Scrambled net variance for integrals of smooth functions", 1997). A place depends on its
// sample's number alone. The mean of the first n places misses the middle by a small part of 1 / n where n is a power
// of 4; that of the R sequence does by up to 1.4 / n and of points not scrambled by 1 / 2n, and moves edges as much.

// Words here are reversed: bit 0 is the half.
static inline uint sequence_directed(uint sample, uint dimension) {
    const uint axis = dimension & 3u;
    // Three directions, each from those before by the axis's primitive polynomial.
    uint a = 1u, b = axis == 0u ? 2u : 3u, c = axis == 1u ? 5u : axis == 2u ? 6u : 4u, sum = 0u;
    for (; sample; sample >>= 1u) {
        if (sample & 1u) sum ^= a;
        uint next = axis == 0u   ? c << 1u
                    : axis == 1u ? c ^ (c << 1u)
                    : axis == 2u ? c ^ b ^ (b << 2u)
                                 : b ^ a ^ (a << 3u);
        a = b;
        b = c;
        c = next;
    }
    return sum;
}

// Every bit flips by a hash of those below: Laine & Karras, "Stratified sampling for stochastic transparency", 2011,
// with the hash of Vegdahl, "Building a Better LK Hash", 2021.
static inline uint sequence_scrambled(uint x, uint dimension) {
    const uint seed = (dimension + 1u) * 0x9e3779b9u;
    x ^= x * 0x3d20adeau;
    x = (x + seed) * ((seed >> 16u) | 1u);
    x ^= x * 0x05526c56u;
    return x ^ (x * 0x53a22864u);
}

// A coordinate in [0, 1) of a sample; sample 0 is the middle.
static inline real sequence_at(uint sample, uint dimension) {
    // The same bits flipped in every sample bring sample 0 there and leave them as even.
    uint x = sequence_scrambled(sequence_directed(sample, dimension), dimension);
    x ^= sequence_scrambled(0u, dimension) ^ 1u;
    x = (x >> 16u) | (x << 16u);
    x = ((x >> 8u) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8u);
    x = ((x >> 4u) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4u);
    x = ((x >> 2u) & 0x33333333u) | ((x & 0x33333333u) << 2u);
    x = ((x >> 1u) & 0x55555555u) | ((x & 0x55555555u) << 1u);
    return (real)((number)(x >> 8u) * 0x1p-24f);
}
