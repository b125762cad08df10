// Emission of the media where flights collide tentatively: these events come at the rate of the majorant σ̄, so that ε / σ̄ at
// each adds up to ∫ ε in the mean (collision estimator: Spanier & Gelbard, "Monte Carlo Principles and Neutron Transport
// Problems", 1969), and a share of it as ε / σ_t where the event is real. It needs no place of its own to look at;
// volume/glow.py says where it is no noisier than emission_along.h.
static inline void emission_of_piece(path *p, const struct world *world, real from, real from_low, real to, real to_low, mask flying) {}
static inline void emission_of_collision(path *p, const struct world *world, integer medium, coefficient own, words w, mask collide) {}

// t: along the segment; w: the words by which σ_t was found; bound: the majorant there; own: of the medium that collides, as
// path_collide has it.
static inline void emission_of_event(path *p, const struct world *world, real t, words w, real bound, integer medium, coefficient own,
                                     mask flying, mask collide) {
    if (!some(flying)) return;
    spectrum along, collided = media_emitted(world, medium, vector_along(p->origin, t, p->direction), w, &along);
    along = spectrum_scale(spectrum_multiply(along, path_weight_at(p, world, t)), EMISSION_KAPPA / bound);
    path_gain(p, along, p->order, flying);
    path there = *p;
    path_survive(&there, world, t, collide);
    path_collide(&there, own, collided, collide);
    path_gain(p, there.throughput, p->order, collide);
}
