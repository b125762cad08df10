// The chance that a path of this largest weight goes on; a third is the least weight that does (README.md).
static inline real roulette_chance(real weight) { return smaller(weight * 3.f, (real)1.f); }
