// The direction in which a path of the small loop goes on.
static inline vector path_scatter(path *p, const struct world *world, words v, mask scatter) {
    return phase_sample(world, p->direction, unit(v.z), unit(v.w));
}
