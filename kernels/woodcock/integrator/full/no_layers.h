// A picture of the beauty alone.
static inline void path_gain(path *p, spectrum gained, integer order, mask chosen) {
    p->radiance = spectrum_pick(p->radiance, spectrum_add(p->radiance, gained), chosen);
}
static inline mask walk_may_be_cut(const path *p) { return (mask)-1; }
static inline void walk_pass(path *p, coefficient sigma_t, real bound, mask walking) {}
static inline void walk_pass_media(path *p, coefficient depth, mask walking) {}
static inline void layers_begin(path *p, const struct world *world, real lead, mask begin) {}
static inline mask layers_probed(path *p, mask walked, mask gone) { return (mask)0; }
static inline real layer_value(const path *p, int k) { return (real)0.f; }
static inline void layers_met(path *p, const struct world *world, vector normal, mask vertex) {}
static inline void layers_scattered(path *p, mask scatter) {}
