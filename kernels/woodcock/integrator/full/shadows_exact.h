// What is lost on the way to a light between constant media and surfaces that let nothing pass: exp(-τ) or everything, known at
// once. No lane walks.
static inline void shadow_ray(path *p, const struct world *world, path ray, const light_sample *sample, spectrum arriving, mask lit) {
    surface_state met = {0};
    ray.direction = sample->towards;
    ray.length = sample->distance;
    surfaces_ahead(&met, &ray, world, &ray.end, lit);
    coefficient depth = clocks_depth(world, &ray, sample->distance);
    arriving = spectrum_attenuate(arriving, coefficient_exp_minus(depth));
    path_gain(p, arriving, p->order + 1, lit & ~surfaces_met(&met, lit));
}

static inline mask shadow_cast(path *p, const surface_state *s, const struct world *world, const light_sample *sample, spectrum arriving,
                               mask lit, mask at_surface) {
    path ray = *p;
    ray.origin = p->position;
    ray.direction = sample->towards;
    surfaces_depart(s, &ray, world, lit & at_surface);
    shadow_ray(p, world, ray, sample, arriving, lit);
    return (mask)0;
}

static inline mask shadow_cast_aside(path *p, const struct world *world, vector at, const light_sample *sample, spectrum arriving, mask lit) {
    path ray = *p;
    ray.origin = at;
    shadow_ray(p, world, ray, sample, arriving, lit);
    return (mask)0;
}
