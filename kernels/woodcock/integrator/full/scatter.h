// The direction in which a path goes on that scatters in a medium, and what weight that has over the phase function's own.
static inline vector path_scatter(const path *p, const struct world *world, words v, real *weight) {
    *weight = (real)1.f;
    return phase_sample(world, p->medium, p->incoming, unit(v.x), unit(v.y));
}
static inline real path_scatter_pdf(const path *p, const struct world *world, vector out) {
    return phase_eval(world, p->medium, p->incoming, out);
}
