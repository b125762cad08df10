// Emission of the media along a piece of a flight that no collision has ended: ∫ ε, by one point a medium. Where a flight
// survives with probability exp(-τ), what it passes needs no weight for it.
static inline void emission_of_piece(path *p, const struct world *world, real from, real to, mask flying) {
    if (!some(flying)) return;
    words w = rng_next(&p->random, flying);
    spectrum emitted = media_emission(world, p, from, to, unit(w.x));
    path_gain(p, emitted, p->order, flying);
}
