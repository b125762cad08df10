// The direction in which a path goes on that scatters in a medium, some of them towards lights, and what weight that has over
// the phase function's own.
static inline vector path_scatter(const path *p, const struct world *world, words v, real *weight) {
    vector axis = guide_axis(world, p->position, p->order);
    real share = guide_share(world, p->order);
    vector out = phase_sample(world, p->medium, p->incoming, unit(v.x), unit(v.y));
    out = vector_pick(out, guide_sample(world, axis, unit(v.x), unit(v.y)), test(unit(v.z) < share));
    real phase = phase_eval(world, p->medium, p->incoming, out);
    *weight = phase / guide_pdf(world, share, axis, out, phase);
    return out;
}
static inline real path_scatter_pdf(const path *p, const struct world *world, vector out) {
    vector axis = guide_axis(world, p->position, p->order);
    real phase = phase_eval(world, p->medium, p->incoming, out);
    return guide_pdf(world, guide_share(world, p->order), axis, out, phase);
}
