// Delta and ratio tracking through all grids at once, under one bound on the sum of their σ_t: a flight collides for good
// with probability σ_t / bound (Woodcock et al. 1965), a walk multiplies by 1 - σ_t / bound (Cramer 1978, Novák et al. 2014).
#include "core/audit.h"
#include "core/box.h"
#include "core/roulette.h"

typedef majorant_walk grid_state;

static inline void grids_start(path *p, const struct world *world, majorant_walk *walk, mask fresh) {
    vector origin = affine_point(&world->scene->tracking.to_local, p->origin);
    vector along = affine_direction(&world->scene->tracking.to_local, p->direction);
    real near = (real)0.f, far = p->end;
    box_clip(world->scene->tracking.size, origin, along, &near, &far);
    mask inside = fresh & test(near < far);
    majorant_start(world, origin, along, near, far, walk, inside);
    p->tracking = (p->tracking & ~fresh) | inside;
    emission_of_piece(p, world, (real)0.f, (real)0.f, near, (real)0.f, inside & ~p->walking);
    p->tracked = pick(p->tracked, pick((real)0.f, near, inside), fresh);
    p->tracked_low = pick(p->tracked_low, (real)0.f, fresh);
}

// One tentative collision. `collided`: flights that have; `lost`: walks that have lost all their weight.
static inline void grids_step(path *p, const struct world *world, majorant_walk *walk, audit *found, mask *collided,
                              mask *lost) {
    mask active = p->tracking;
    words w = rng_next(&p->random, active);
    real u, depth = rng_flight(&p->random, w, &u);
    mask out = majorant_step(world, walk, depth, active);
    mask event = active & ~out, flying = event & ~p->walking, walking = event & p->walking;
    integer medium;
    coefficient own, sigma_t = grids_sigma_t(world, p, walk->t, w, u * walk->bound, &medium, &own);
    real largest = coefficient_max(sigma_t);
    audit_majorant(found, largest / walk->bound, spectrum_max(p->throughput), event & test(largest > walk->bound * 1.000001f));

    mask collide = flying & test(u * walk->bound < coefficient_of_hero(sigma_t, p->hero));
    real low = pick(walk->t_low, (real)0.f, out);
    emission_of_piece(p, world, p->tracked, p->tracked_low, walk->t, low, active & ~p->walking);
    p->tracked = pick(p->tracked, walk->t, active);
    p->tracked_low = pick(p->tracked_low, low, active);
    emission_of_event(p, world, walk->t, w, walk->bound, medium, own, flying, collide);
    path_null(p, sigma_t, walk->bound, flying & ~collide);

    coefficient kept;
    for (int c = 0; c < COEFFICIENTS; ++c)
        coefficient_channel(kept, c) = larger((real)0.f, 1.f - coefficient_channel(sigma_t, c) / walk->bound);
    coefficient through = coefficient_multiply(p->transmittance, kept);
    // Faint walks play roulette; `u` has not decided anything in walks yet.
    real chance = pick((real)1.f, roulette_chance(coefficient_max(through)), walking & walk_may_be_cut(p));
    through = coefficient_scale(through, pick((real)0.f, 1.f / chance, test(u <= chance)));
    p->transmittance = coefficient_pick(p->transmittance, through, walking);
    walk_pass(p, sigma_t, walk->bound, walking);

    *lost = walking & walk_may_be_cut(p) & test(coefficient_max(p->transmittance) <= 0.f);
    *collided = collide;
    p->medium = pick(p->medium, medium, collide);
    p->tracking = active & ~(out | collide | *lost);
    if (some(collide)) {
        p->position = vector_pick(p->position, vector_along(p->origin, walk->t, p->direction), collide);
        words v = rng_next(&p->random, collide);
        path_survive(p, world, walk->t, collide);
        emission_of_collision(p, world, medium, own, w, collide);
        path_collide(p, own, media_albedo(world, medium, p->position, v), collide);
    }
}
