// Tracking through all media that are grids at once, as grids.h, by the kinds that the scene asks for: flights_*.h tell what
// an event is to flights, walks_*.h what it is to walks.
#include "core/box.h"
#include "core/roulette.h"

static inline void grids_start(path *p, const struct world *world, grid_state *g, mask fresh) {
    vector origin = affine_point(&world->scene->tracking.to_local, p->origin);
    vector along = affine_direction(&world->scene->tracking.to_local, p->direction);
    real near = (real)0.f, far = p->end;
    box_clip(world->scene->tracking.size, origin, along, &near, &far);
    mask inside = fresh & test(near < far);
    majorant_start(world, origin, along, near, far, &g->walk, inside);
    walks_start(p, world, g, inside & p->walking);
    p->tracking = (p->tracking & ~fresh) | inside;
    emission_of_piece(p, world, (real)0.f, (real)0.f, near, (real)0.f, inside & ~p->walking);
    p->tracked = pick(p->tracked, pick((real)0.f, near, inside), fresh);
    p->tracked_low = pick(p->tracked_low, (real)0.f, fresh);
}

// One step. `collided`: flights that have; `lost`: walks that have lost all their weight.
static inline void grids_step(path *p, const struct world *world, grid_state *g, audit *found, mask *collided, mask *lost) {
    majorant_walk *walk = &g->walk;
    mask active = p->tracking, walking = active & p->walking, flying = active & ~p->walking;
    words w = rng_next(&p->random, active);
    real u, depth = rng_flight(&p->random, w, &u);
    mask out = walks_step(p, world, g, w, depth, active), event = active & ~out;
    integer medium;
    coefficient own, sigma_t;
    mask collide = flights_meet(p, world, walk, w, u, found, event & flying, event & walking, &medium, &own, &sigma_t);
    sigma_t = walks_residual(world, walk, sigma_t, found, event & walking);
    real largest = coefficient_max(sigma_t);
    audit_majorant(found, largest / walk->bound, spectrum_max(p->throughput), event & test(largest > walk->bound * 1.000001f));

    real low = pick(walk->t_low, (real)0.f, out);
    emission_of_piece(p, world, p->tracked, p->tracked_low, walk->t, low, flying);
    p->tracked = pick(p->tracked, walk->t, active);
    p->tracked_low = pick(p->tracked_low, low, active);
    emission_of_event(p, world, walk->t, w, walk->bound, medium, own, event & flying, collide);
    path_null(p, sigma_t, walk->bound, event & flying & ~collide);
    *collided = collide;
    p->medium = pick(p->medium, medium, collide);
    if (some(collide)) {
        p->position = vector_pick(p->position, vector_along(p->origin, walk->t, p->direction), collide);
        words v = rng_next(&p->random, collide);
        path_survive(p, world, walk->t, collide);
        emission_of_collision(p, world, medium, own, w, collide);
        path_collide(p, own, media_albedo(world, medium, p->position, v), collide);
    }

    // Faint walks play roulette; `u` has not decided anything in walks yet.
    coefficient through = p->transmittance;
    mask weighed = walks_pass(p, world, g, sigma_t, walking, &out, &through);
    real chance = pick((real)1.f, roulette_chance(walks_size(through)), weighed & walk_may_be_cut(p));
    through = coefficient_scale(through, pick((real)0.f, 1.f / chance, test(u <= chance)));
    p->transmittance = coefficient_pick(p->transmittance, through, weighed);
    *lost = weighed & walk_may_be_cut(p) & test(walks_size(p->transmittance) <= 0.f);
    p->tracking = active & ~(out | collide | *lost);
}
