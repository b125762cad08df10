// Walks: rays that measure transmittance from a vertex, as a mode of the lane.
static inline void walk_start(path *p, vector direction, real length, mask chosen) {
    p->direction = vector_pick(p->direction, direction, chosen);
    p->origin = vector_pick(p->origin, p->position, chosen);
    p->length = pick(p->length, length, chosen);
    p->transmittance = coefficient_pick(p->transmittance, coefficient_grey((real)1.f), chosen);
    p->walking |= chosen;
    p->fresh |= chosen;
}

// A flight, or one that has waited for a walk, sets out from the vertex along `direction`.
static inline void flight_start(path *p, vector direction, mask chosen) {
    p->direction = vector_pick(p->direction, direction, chosen);
    p->origin = vector_pick(p->origin, p->position, chosen);
    p->departed = vector_pick(p->departed, p->position, chosen & ~p->aside);
    p->length = pick(p->length, (real)1e30f, chosen);
    p->inside = pick(p->inside, p->inside_there, chosen);
    p->walking &= ~chosen;
    p->fresh |= chosen;
}
