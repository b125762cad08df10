// Coefficients of extinction, grey: one number for every channel. `hero` is not used.
typedef real coefficient;
#define COEFFICIENTS 1
#define coefficient_channel(a, c) (a)

static inline coefficient coefficient_grey(real v) { return v; }
static inline coefficient coefficient_add(coefficient a, coefficient b) { return a + b; }
static inline coefficient coefficient_multiply(coefficient a, coefficient b) { return a * b; }
static inline coefficient coefficient_scale(coefficient a, real s) { return a * s; }
static inline coefficient coefficient_pick(coefficient no, coefficient yes, mask chosen) { return pick(no, yes, chosen); }
static inline real coefficient_of_hero(coefficient a, integer hero) { return a; }
static inline real coefficient_mean(coefficient a) { return a; }
static inline real coefficient_max(coefficient a) { return a; }
static inline coefficient coefficient_exp_minus(coefficient a) { return exp(-a); }
static inline spectrum spectrum_attenuate(spectrum s, coefficient a) { return spectrum_scale(s, a); }
