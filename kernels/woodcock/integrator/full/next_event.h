// Next-event estimation: from every vertex towards a light, weighed against finding that light by chance with the balance
// heuristic (Veach & Guibas 1995). shadows_*.h tell what is lost on the way.
static inline mask next_event_start(path *p, const surface_state *s, const struct world *world, mask vertex) {
    if (!some(vertex)) return (mask)0;
    words w = rng_next(&p->random, vertex);
    light_sample sample;
    integer light = light_choose(world, p->position, unit(w.x), unit(w.y), unit(w.z), &sample);
    mask at_surface = vertex & test(p->medium < 0);
    spectrum value = spectrum_grey(phase_eval(world, p->medium, p->incoming, sample.towards));
    real pdf = scatter_pdf(p, world, sample.towards);
    surfaces_eval(s, p, world, sample.towards, &value, &pdf, at_surface);
    real weight = pick((real)1.f, sample.pdf / (sample.pdf + pdf), test(sample.pdf > 0.f));
    weight *= equiangular_weight(p, world, light, vertex & ~at_surface);
    real chance = shadow_chance(spectrum_max(value) * weight);
    spectrum arriving = spectrum_scale(spectrum_multiply(spectrum_multiply(p->throughput, value), sample.weight), weight / chance);
    mask lit = vertex & test(unit(w.w) < chance) & test(spectrum_max(arriving) > 0.f);
    return shadow_cast(p, s, world, &sample, arriving, lit, at_surface);
}

static inline void next_event_arrive(path *p, mask arrived) {
    path_gain(p, spectrum_attenuate(p->light, p->transmittance), p->order + 1, arrived);
}
