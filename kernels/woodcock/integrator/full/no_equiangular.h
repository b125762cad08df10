// A scene without points of light in constant media.
static inline real equiangular_weight(const path *p, const struct world *world, integer light, mask vertex) { return (real)1.f; }
static inline mask equiangular_start(path *p, const struct world *world, mask flying) { return (mask)0; }
