// Coefficients of extinction, one a channel.
typedef spectrum coefficient;
#define COEFFICIENTS 3
#define coefficient_channel(a, c) spectrum_channel(a, c)

static inline coefficient coefficient_grey(real v) { return spectrum_grey(v); }
static inline coefficient coefficient_add(coefficient a, coefficient b) { return spectrum_add(a, b); }
static inline coefficient coefficient_multiply(coefficient a, coefficient b) { return spectrum_multiply(a, b); }
static inline coefficient coefficient_scale(coefficient a, real s) { return spectrum_scale(a, s); }
static inline coefficient coefficient_pick(coefficient no, coefficient yes, mask chosen) {
    return spectrum_pick(no, yes, chosen);
}
static inline real coefficient_of_hero(coefficient a, integer hero) {
    return pick(a.channel[0], pick(a.channel[1], a.channel[2], test(hero == 2)), test(hero > 0));
}
static inline real coefficient_mean(coefficient a) { return (a.channel[0] + a.channel[1] + a.channel[2]) * (1.f / 3.f); }
static inline real coefficient_max(coefficient a) { return spectrum_max(a); }
static inline coefficient coefficient_exp_minus(coefficient a) {
    return spectrum_of(exp(-a.channel[0]), exp(-a.channel[1]), exp(-a.channel[2]));
}
static inline spectrum spectrum_attenuate(spectrum s, coefficient a) { return spectrum_multiply(s, a); }
