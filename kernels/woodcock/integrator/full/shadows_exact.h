// What is lost on the way to a light between constant media and surfaces that let nothing pass: exp(-τ) or everything, known at
// once. No lane walks.
// Only what its functions read of a path is set: copying all of it costs as much as the ray.
static inline path shadow_path(const path *p, vector origin, const light_sample *sample) {
    path ray;
    ray.origin = origin;
    ray.direction = sample->towards;
    ray.length = ray.end = sample->distance;
    ray.incoming = p->incoming;
    ray.inside = p->inside;
    return ray;
}

static inline void shadow_ray(path *p, const struct world *world, path *ray, spectrum arriving, mask lit) {
    surface_state met = {0};
    surfaces_ahead(&met, ray, world, &ray->end, lit);
    coefficient depth = clocks_depth(world, ray, ray->length);
    arriving = spectrum_attenuate(arriving, coefficient_exp_minus(depth));
    path_gain(p, arriving, p->order + 1, lit & ~surfaces_met(&met, lit));
}

static inline real shadow_chance(real scattered) { return (real)1.f; }

static inline mask shadow_cast(path *p, const surface_state *s, const struct world *world, const light_sample *sample, spectrum arriving,
                               mask lit, mask at_surface) {
    path ray = shadow_path(p, p->position, sample);
    surfaces_depart(s, &ray, world, lit & at_surface);
    shadow_ray(p, world, &ray, arriving, lit);
    return (mask)0;
}

static inline mask shadow_cast_aside(path *p, const struct world *world, vector at, const light_sample *sample, spectrum arriving, mask lit) {
    path ray = shadow_path(p, at, sample);
    shadow_ray(p, world, &ray, arriving, lit);
    return (mask)0;
}
