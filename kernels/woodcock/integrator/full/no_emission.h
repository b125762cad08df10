// Media that do not shine.
static inline void emission_of_piece(path *p, const struct world *world, real from, real to, mask flying) {}
