// Spectra, one channel: a grey scene. `spectrum` holds lanes, `colour` the same for all lanes.
#define CHANNELS 1
typedef real spectrum;
typedef number colour;
#define spectrum_channel(s, c) (s)

static inline spectrum spectrum_uniform(colour c) { return (real)c; }
static inline spectrum spectrum_grey(real v) { return v; }
static inline spectrum spectrum_add(spectrum a, spectrum b) { return a + b; }
static inline spectrum spectrum_multiply(spectrum a, spectrum b) { return a * b; }
static inline spectrum spectrum_scale(spectrum a, real s) { return a * s; }
static inline spectrum spectrum_pick(spectrum no, spectrum yes, mask chosen) { return pick(no, yes, chosen); }
static inline real spectrum_max(spectrum a) { return a; }
