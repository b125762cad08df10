// Emission of the media along a piece of a flight that no collision has ended: ∫ ε, by one point a medium. Where a flight
// survives with probability exp(-τ), what it passes needs no weight for it. from_low, to_low: what rounding left of its ends;
// in an opaque medium far from the origin a piece is shorter than that.
static inline void emission_of_piece(path *p, const struct world *world, real from, real from_low, real to, real to_low, mask flying) {
    if (!some(flying)) return;
    words w = rng_next(&p->random, flying);
    spectrum emitted = media_emission(world, p, from, from_low, to, to_low, w);
    path_gain(p, emitted, p->order, flying);
}
