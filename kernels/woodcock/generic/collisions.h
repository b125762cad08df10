// What the loop asks of any media: albedo, emission along a piece, and σ_t of all grids under their majorant.
static inline spectrum media_albedo(const struct world *world, integer medium, vector x, words w) {
    spectrum albedo = spectrum_grey((real)0.f);
    for (int i = 0; i < world->scene->held.media; ++i) {
        mask here = test(medium == i);
        if (!world->scene->held.scattering || !some(here)) continue;
        albedo = spectrum_pick(albedo, medium_albedo(world, i, medium_local(world, i, x), w), here);
    }
    return albedo;
}

static inline coefficient medium_sigma_t_there(const struct world *world, int i, vector p, words w) {
    return world->scene->media[i].grid ? medium_sigma_t(world, i, p, w) : medium_sigma_t_exact(world, i, p);
}

// What medium `medium` emits where a flight collides with it, the share of collisions.
static inline spectrum media_emitted(const struct world *world, integer medium, vector x, words w, spectrum *others) {
    spectrum sum = spectrum_grey((real)0.f);
    for (int i = 0; i < world->scene->held.media; ++i) {
        if (world->scene->media[i].emission == EMISSION_NONE) continue;
        vector at = medium_local(world, i, x);
        spectrum found = emission_collided(medium_emission(world, i, at), medium_sigma_t_there(world, i, at, w));
        sum = spectrum_pick(sum, found, test(medium == i));
    }
    return sum;
}

// ∫ ε along a piece of a segment, its share, by a random point of what each medium has of it.
static inline spectrum media_emission(const struct world *world, const path *p, real from, real from_low, real to,
                                      real to_low, words w) {
    spectrum sum = spectrum_grey((real)0.f);
    for (int i = 0; i < world->scene->held.media; ++i) {
        __constant const struct medium *medium = &world->scene->media[i];
        if (medium->emission == EMISSION_NONE) continue;
        real near = from, far = to;
        if (medium->grid) {
            box_clip(medium->size, affine_point(&medium->to_local, p->origin),
                     affine_direction(&medium->to_local, p->direction), &near, &far);
        } else {
            clocks_interval(world, p, i, to, &near, &far);
            near = larger(near, from);
        }
        real length = far - near + pick((real)0.f, to_low, test(far == to));
        length = larger(length - pick((real)0.f, from_low, test(near == from)), (real)0.f);
        real t = near + unit(w.x) * length;
        vector at = medium_local(world, i, vector_along(p->origin, t, p->direction));
        spectrum found = emission_along(medium_emission(world, i, at), medium_sigma_t_there(world, i, at, w));
        found = spectrum_scale(spectrum_multiply(found, path_weight_at(p, world, t)), length);
        sum = spectrum_pick(sum, spectrum_add(sum, found), test(length > 0.f));
    }
    return sum;
}

static inline void majorant_start(const struct world *world, vector origin, vector along, real near, real far,
                                  majorant_walk *walk, mask chosen) {
    majorant_grid_start(&world->scene->majorant, world->majorant_grid_bounds, origin, along, near, far, walk, chosen);
}
static inline mask majorant_step(const struct world *world, majorant_walk *walk, real depth, mask active) {
    return majorant_grid_step(&world->scene->majorant, world->majorant_grid_bounds, walk, depth, active);
}
// σ_t of the grids at t; `level`, uniform up to the bound, chooses the medium that collides.
static inline coefficient grids_sigma_t(const struct world *world, const path *p, real t, words w, real level,
                                        integer *medium, coefficient *own) {
    vector x = vector_along(p->origin, t, p->direction);
    coefficient total = coefficient_grey((real)0.f);
    *medium = (integer)-1;
    *own = total;
    for (int i = 0; i < world->scene->held.media; ++i) {
        if (!world->scene->media[i].grid) continue;
        coefficient sigma_t = medium_sigma_t(world, i, medium_local(world, i, x), w);
        mask chosen = test(*medium < 0) & test(level < coefficient_of_hero(coefficient_add(total, sigma_t), p->hero));
        *medium = pick(*medium, (integer)i, chosen);
        *own = coefficient_pick(*own, sigma_t, chosen);
        total = coefficient_add(total, sigma_t);
    }
    return total;
}
