// Spectra, three channels: red, green, blue. `spectrum` holds lanes, `colour` the same for all lanes.
#define CHANNELS 3
typedef struct { real channel[3]; } spectrum;
typedef struct { number r, g, b; } colour;
#define spectrum_channel(s, c) ((s).channel[c])

static inline spectrum spectrum_of(real r, real g, real b) {
    spectrum s = {{r, g, b}};
    return s;
}

static inline spectrum spectrum_uniform(colour c) { return spectrum_of((real)c.r, (real)c.g, (real)c.b); }
static inline spectrum spectrum_grey(real v) { return spectrum_of(v, v, v); }

static inline spectrum spectrum_add(spectrum a, spectrum b) {
    return spectrum_of(a.channel[0] + b.channel[0], a.channel[1] + b.channel[1], a.channel[2] + b.channel[2]);
}

static inline spectrum spectrum_multiply(spectrum a, spectrum b) {
    return spectrum_of(a.channel[0] * b.channel[0], a.channel[1] * b.channel[1], a.channel[2] * b.channel[2]);
}

static inline spectrum spectrum_scale(spectrum a, real s) {
    return spectrum_of(a.channel[0] * s, a.channel[1] * s, a.channel[2] * s);
}

static inline spectrum spectrum_pick(spectrum no, spectrum yes, mask chosen) {
    return spectrum_of(pick(no.channel[0], yes.channel[0], chosen), pick(no.channel[1], yes.channel[1], chosen),
                       pick(no.channel[2], yes.channel[2], chosen));
}

static inline real spectrum_max(spectrum a) { return larger(a.channel[0], larger(a.channel[1], a.channel[2])); }
