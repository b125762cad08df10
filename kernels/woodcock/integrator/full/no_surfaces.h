// A scene without surfaces.
typedef struct { int unused; } surface_state;
static inline void surfaces_ahead(surface_state *s, path *p, const struct world *world, real *end, mask fresh) {}
static inline mask surfaces_met(const surface_state *s, mask arrived) { return (mask)0; }
static inline mask surfaces_meet(surface_state *s, path *p, const struct world *world, mask met, mask *lost) { return (mask)0; }
static inline mask surfaces_scatter_anywhere(const surface_state *s, const struct world *world) { return (mask)0; }
static inline mask surfaces_given_up(surface_state *s, mask begin) { return (mask)0; }
static inline void surfaces_eval(const surface_state *s, const path *p, const struct world *world, vector towards,
                                 spectrum *value, real *pdf, mask at_surface) {}
static inline void surfaces_depart(const surface_state *s, path *p, const struct world *world, mask leaving) {}
static inline void surfaces_scatter(surface_state *s, path *p, const struct world *world, mask scatter) {}
static inline vector surfaces_normal(const surface_state *s) { return vector_of((real)0.f, (real)0.f, (real)0.f); }
