// Media that do not shine.
static inline void emission_of_piece(path *p, const struct world *world, real from, real from_low, real to, real to_low, mask flying) {}
static inline void emission_of_collision(path *p, const struct world *world, integer medium, coefficient own, words w, mask collide) {}
static inline void emission_of_event(path *p, const struct world *world, real t, words w, real bound, integer medium, coefficient own,
                                     mask flying, mask collide) {}
