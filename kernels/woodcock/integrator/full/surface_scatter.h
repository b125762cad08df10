// How a path leaves a surface. pdf: of the direction, 0 from a mirror.
static inline void surface_scatter(const path *p, const struct world *world, const surface_point *at, words w, vector *out,
                                   spectrum *weight, real *pdf) {
    material_sample(world, at->surface, p->incoming, at->shading, at->geometric, unit(w.x), unit(w.y), unit(w.z), out, weight, pdf);
}
static inline void surface_scatter_eval(const path *p, const struct world *world, const surface_point *at, vector towards,
                                        spectrum *value, real *pdf) {
    material_eval(world, at->surface, p->incoming, towards, at->shading, at->geometric, value, pdf);
}
