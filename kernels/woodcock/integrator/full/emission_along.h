// Emission of the media along pieces of flights, and where flights collide, a share of it each.

// A piece of a flight that no collision has ended: its share of ∫ ε, by one point a medium. Where a flight survives with
// probability exp(-τ), what it passes needs no weight for it. from_low, to_low: what rounding left of its ends; in an opaque
// medium far from the origin a piece is shorter than that.
static inline void emission_of_piece(path *p, const struct world *world, real from, real from_low, real to, real to_low, mask flying) {
    if (!some(flying)) return;
    words w = rng_next(&p->random, flying);
    spectrum emitted = media_emission(world, p, from, from_low, to, to_low, w);
    path_gain(p, emitted, p->order, flying);
}

// A collision with `medium`. own: as path_collide has it; w: the words by which σ_t was found.
static inline void emission_of_collision(path *p, const struct world *world, integer medium, coefficient own, words w, mask collide) {
    spectrum others;
    path there = *p;
    path_collide(&there, own, media_emitted(world, medium, p->position, w, &others), collide);
    path_gain(p, there.throughput, p->order, collide);
}

static inline void emission_of_event(path *p, const struct world *world, real t, words w, real bound, integer medium, coefficient own,
                                     mask flying, mask collide) {}
