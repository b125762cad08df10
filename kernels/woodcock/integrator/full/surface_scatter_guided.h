// How a path leaves a surface, sometimes towards a light that shines through media: of what they scatter most comes from around
// it. pdf: of the direction, 0 from a mirror.
static inline void surface_scatter_eval(const path *p, const struct world *world, const surface_point *at, vector towards,
                                        spectrum *value, real *pdf) {
    material_eval(world, at->surface, p->incoming, towards, at->shading, at->geometric, value, pdf);
    *pdf = guide_pdf(world, guide_surface_share(world, p->order), guide_axis(world, p->position, p->order), towards, *pdf);
}
static inline void surface_scatter(const path *p, const struct world *world, const surface_point *at, words w, vector *out,
                                   spectrum *weight, real *pdf) {
    material_sample(world, at->surface, p->incoming, at->shading, at->geometric, unit(w.x), unit(w.y), unit(w.z), out, weight, pdf);
    mask rough = test(*pdf > 0.f), guided = rough & test(unit(w.w) < guide_surface_share(world, p->order));
    *out = vector_pick(*out, guide_sample(world, guide_axis(world, p->position, p->order), unit(w.x), unit(w.y)), guided);
    spectrum value;
    real density;
    surface_scatter_eval(p, world, at, *out, &value, &density);
    *weight = spectrum_pick(*weight, spectrum_scale(value, 1.f / density), rough);
    *pdf = pick(*pdf, density, rough);
}
