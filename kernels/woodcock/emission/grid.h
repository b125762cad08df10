// An emission coefficient from a grid of numbers or colours: ε = scale × value.
static inline spectrum emission_grid_epsilon(__constant const struct emission_grid *emission, spectrum value) {
    return spectrum_multiply(spectrum_uniform(emission->scale), value);
}
