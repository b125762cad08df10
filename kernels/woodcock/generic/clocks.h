// Free flight and transmittance of media that are no grids: exponential clocks, and exp(-τ), each in closed form.

// Where the segment runs through medium i, from 0 to `to`: near < far if it does at all.
static inline void clocks_interval(const struct world *world, const path *p, int i, real to, real *near, real *far) {
    __constant const struct scene *scene = world->scene;
    const int shape = scene->media[i].shape;
    *near = (real)0.f;
    *far = to;
    if (shape == SHAPE_BOX)
        shape_box_interval(&scene->shape_box[i], affine_point(&scene->shape_box[i].to_local, p->origin),
                           affine_direction(&scene->shape_box[i].to_local, p->direction), near, far);
    if (shape == SHAPE_SPHERE)
        shape_sphere_interval(&scene->shape_sphere[i], affine_point(&scene->shape_sphere[i].to_local, p->origin),
                              affine_direction(&scene->shape_sphere[i].to_local, p->direction), near, far);
    if (shape == SHAPE_MESH) shape_mesh_interval(&scene->shape_mesh[i], p->inside, far);
}

// Does the clock of a medium between near and far ring there, at what length, and what did rounding leave of that?
static inline mask clocks_time(path *p, real near, real far, real sigma_t, mask flying, real *t, real *low) {
    words w = rng_next(&p->random, flying);
    real unused, flight = rng_flight(&p->random, w, &unused) / sigma_t;
    *t = near + flight;
    mask ringing = test(flight < far - near + pick((real)0.f, p->end_low, test(far == p->end)));
    *low = pick((real)0.f, flight - (*t - near), ringing);
    return ringing;
}
static inline void clocks_ring(const struct world *world, path *p, mask flying) {
    if (!some(flying)) return;
    for (int i = 0; i < world->scene->held.media; ++i) {
        if (world->scene->media[i].grid) continue;
        real near, far, t, low;
        clocks_interval(world, p, i, p->end, &near, &far);
        coefficient sigma_t = spectrum_uniform(world->scene->media[i].sigma_t);
        mask ringing = flying & clocks_time(p, near, far, coefficient_of_hero(sigma_t, p->hero), flying, &t, &low);
        p->end = pick(p->end, t, ringing);
        p->end_low = pick(p->end_low, low, ringing);
        p->clock = pick(p->clock, (integer)i, ringing);
    }
}
// Optical depth of the constant media up to t.
static inline coefficient clocks_depth(const struct world *world, const path *p, real t) {
    coefficient sum = coefficient_grey((real)0.f);
    for (int i = 0; i < world->scene->held.media; ++i) {
        if (world->scene->media[i].grid) continue;
        real near, far;
        clocks_interval(world, p, i, t, &near, &far);
        coefficient sigma_t = spectrum_uniform(world->scene->media[i].sigma_t);
        sum = coefficient_add(sum, coefficient_scale(sigma_t, larger(far - near, (real)0.f)));
    }
    return sum;
}
static inline coefficient clocks_own(const struct world *world, integer medium) {
    coefficient own = coefficient_grey((real)0.f);
    for (int i = 0; i < world->scene->held.media; ++i) {
        mask here = test(medium == i);
        if (!world->scene->media[i].grid) own = coefficient_pick(own, spectrum_uniform(world->scene->media[i].sigma_t), here);
    }
    return own;
}

// The hull of the segment's parts in constant media: near < far if there are any.
static inline void clocks_span(const struct world *world, const path *p, real *near, real *far) {
    *near = (real)1e30f;
    *far = (real)-1e30f;
    for (int i = 0; i < world->scene->held.media; ++i) {
        real a, b;
        clocks_interval(world, p, i, p->reach, &a, &b);
        *near = pick(*near, smaller(*near, a), test(a < b));
        *far = pick(*far, larger(*far, b), test(a < b));
    }
}
// σ_t of all media at t, and one of them, chosen by its share of it with u: `own` is its σ_t over its chance.
static inline coefficient clocks_sigma_t(const struct world *world, const path *p, real t, real u, integer *medium,
                                         coefficient *own) {
    const int count = world->scene->held.media;
    real means[MOST_MEDIA], sum = (real)0.f;
    coefficient total = coefficient_grey((real)0.f);
    for (int i = 0; i < count; ++i) {
        real a, b;
        clocks_interval(world, p, i, p->reach, &a, &b);
        coefficient sigma_t = spectrum_uniform(world->scene->media[i].sigma_t);
        sigma_t = coefficient_scale(sigma_t, pick((real)0.f, (real)1.f, test(a <= t) & test(t <= b)));
        total = coefficient_add(total, sigma_t);
        means[i] = coefficient_mean(sigma_t);
    }
    const real mean = coefficient_mean(total);
    *medium = (integer)-1;
    real chance = (real)1.f;
    for (int i = 0; i < count; ++i) {
        mask chosen = test(*medium < 0) & test(u * mean < sum + means[i]);
        *medium = pick(*medium, (integer)i, chosen);
        chance = pick(chance, means[i] / mean, chosen);
        sum += means[i];
    }
    *own = coefficient_scale(clocks_own(world, *medium), 1.f / chance);
    return total;
}
