// Russian roulette: with which chance what goes on, and weighs so much more.

// Below a fifth of the weight by odds that lift it there, even ones at worst.
static inline real roulette_chance(real weight) {
    return pick((real)0.f, smaller(larger(weight * 5.f, (real)0.5f), (real)1.f), test(weight != 0.f));
}

// A walk to a light is as long whatever it brings: of what scatters into its direction, over what even scattering would; an
// eighth at least, as nothing else may bring any.
static inline real roulette_walk(real scattered) { return smaller(larger(12.5663706f * scattered, (real)0.125f), (real)1.f); }
