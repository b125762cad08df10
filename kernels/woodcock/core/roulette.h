// The chance that a path of this largest weight goes on (README.md).
static inline real roulette_chance(real weight) {
    return pick((real)0.f, smaller(larger(weight * 3.f, (real)0.5f), (real)1.f), test(weight != 0.f));
}
