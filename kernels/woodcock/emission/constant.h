// One emission coefficient everywhere in the medium; also B(T) of a medium of one temperature.
static inline spectrum emission_constant_epsilon(__constant const struct emission_constant *emission) {
    return spectrum_uniform(emission->epsilon);
}
