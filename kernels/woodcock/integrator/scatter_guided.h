// The direction in which a path of the small loop goes on, some of them towards lights.
static inline vector path_scatter(path *p, const struct world *world, words v, mask scatter) {
    vector axis = guide_axis(world, p->order);
    real share = guide_share(world, p->order), u = unit(v.z);
    mask guided = test(u < share);
    // One uniform chooses the lobe and, stretched again, samples it.
    u = pick((u - share) / (1.f - share), u / share, guided);
    vector out = vector_pick(phase_sample(world, p->direction, u, unit(v.w)), guide_sample(world, axis, u, unit(v.w)), guided);
    real phase = phase_eval(world, p->direction, out), weight = phase / guide_pdf(world, share, axis, out, phase);
    p->throughput = spectrum_pick(p->throughput, spectrum_scale(p->throughput, weight), scatter);
    p->order = pick(p->order, p->order + 1, scatter);
    return out;
}
