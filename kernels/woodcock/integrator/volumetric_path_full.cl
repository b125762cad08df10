// The volume rendering equation with everything that a scene can hold: L = L0 + K L0 + K² L0 + …, by tracing paths from the
// camera. A lane is one path of its own pixel; one whose path ends starts its pixel's next sample at once.
//
// A lane walks segments. Each begins by asking what lies ahead: the nearest surface, and the collision that each constant
// medium would make by itself; the first of them ends it, unless tracking through the grids collides before. Media add
// because the first of independent exponential clocks rings as one clock of the sum of their rates, and it is the
// medium's turn that rang: their phase functions mix by themselves. Where a path collides, it sends a walk, another kind of
// segment, to a light, and scatters when the walk has ended.
#include "core/audit.h"
#include "core/box.h"
#include "core/moments.h"
#include "core/roulette.h"

// The camera ray of the path's sample, from where it enters the bounds of the scene; one that misses has no length.
static inline void path_begin(path *p, surface_state *s, const struct world *world, integer x, integer y, mask begin) {
    p->random.dimension = pick(p->random.dimension, (word)0u, begin);
    words w = rng_next(&p->random, begin);
    int width = world->scene->film.width, height = world->scene->film.height;
    real u = (to_real(x) + 0.5f + filter_offset(world, unit(w.x))) / (float)width;
    real v = (to_real(y) + 0.5f + filter_offset(world, unit(w.y))) / (float)height;
    vector anchor, direction;
    real start, far = (real)1e30f;
    camera_ray(world, u, v, unit(w.z), unit(w.w), &anchor, &direction, &start);
    vector3 low = world->scene->bounds.low;
    real near = start;
    box_clip(world->scene->bounds.size, vector_along(anchor, (real)-1.f, vector_uniform(low)), direction, &near, &far);
    mask misses = test(near >= far);
    near = pick(near, start, misses);
    p->position = vector_pick(p->position, vector_along(anchor, near, direction), begin);
    p->inside_there = pick(p->inside_there, (word)world->scene->bounds.inside, begin);
    p->aside &= ~begin;
    flight_start(p, direction, begin);
    p->length = pick(p->length, (real)0.f, begin & misses);
    p->throughput = spectrum_pick(p->throughput, spectrum_grey((real)1.f), begin);
    p->radiance = spectrum_pick(p->radiance, spectrum_grey((real)0.f), begin);
    p->pdf = pick(p->pdf, (real)1e30f, begin);
    p->order = pick(p->order, (integer)0, begin);
    p->asked &= ~begin;
    path_hero(p, begin);
    layers_begin(p, world, near - start, begin);
}

// What ends the segments that begin.
static inline void segments_begin(path *p, surface_state *s, const struct world *world, grid_state *walk) {
    mask fresh = p->fresh;
    real end = p->length;
    surfaces_ahead(s, p, world, &end, fresh);
    p->reach = pick(p->reach, end, fresh);
    p->end = pick(p->end, end, fresh);
    p->end_low = pick(p->end_low, (real)0.f, fresh);
    fresh &= ~equiangular_start(p, world, fresh & ~p->walking);
    mask flying = fresh & ~p->walking, walking = fresh & p->walking;
    p->clock = pick(p->clock, (integer)-1, fresh);
    clocks_ring(world, p, flying);
    if (some(walking)) {
        coefficient depth = clocks_depth(world, p, p->end);
        coefficient through = coefficient_multiply(p->transmittance, coefficient_exp_minus(depth));
        p->transmittance = coefficient_pick(p->transmittance, through, walking);
        walk_pass_media(p, depth, walking);
    }
    grids_start(p, world, walk, fresh);
    p->fresh &= ~fresh;
}

static inline void volumetric_path_full(const struct world *world, __global float *film, __global uint *faults, uint first, uint samples, integer pixel) {
    const uint lane0 = get_global_id(0) * LANES, pixels = get_global_size(0) * LANES;
    const int width = world->scene->film.width;
    const integer y = pixel / width, x = pixel - y * width;

    // Every lane starts the first sample of its pixel.
    path p = {{(word)0u}};
    surface_state s = {0};
    grid_state walk = {0};
    p.random.pixel = integer_as_word(pixel);
    p.random.sample = (word)first;
    p.random.seed = world->scene->film.seed;
    mask live = (mask)-1, begin = live;
    moments sums[CHANNELS + LAYERS] = {{0}};
    audit found = {0};
    const word last = (word)(first + samples - 1u);

    while (some(live)) {
        // Paths begin at one place, which is inlined.
        if (some(begin)) path_begin(&p, &s, world, x, y, begin);
        if (some(p.fresh)) segments_begin(&p, &s, world, &walk);
        mask collided, lost;
        grids_step(&p, world, &walk, &found, &collided, &lost);
        mask ended = live & ~p.tracking & ~p.fresh;
        begin = (mask)0;
        if (!some(ended)) continue;

        // What ended the segment: a collision in a constant medium, a surface, or nothing at all.
        mask arrived = ended & ~collided & ~lost, flown = arrived & ~p.walking;
        emission_of_piece(&p, world, p.tracked, p.tracked_low, p.end, p.end_low, flown);
        path_survive(&p, world, p.end, flown);
        mask rung = flown & test(p.clock >= 0);
        if (some(rung)) {
            p.position = vector_pick(p.position, vector_along(p.origin, p.end, p.direction), rung);
            p.medium = pick(p.medium, p.clock, rung);
            words v = rng_next(&p.random, rung);
            emission_of_collision(&p, world, p.clock, clocks_own(world, p.clock), v, rung);
            path_collide(&p, clocks_own(world, p.clock), media_albedo(world, p.clock, p.position, v), rung);
        }
        mask met = surfaces_met(&s, arrived & ~rung), gone = arrived & ~rung & ~met;
        mask vertex = collided | rung | surfaces_meet(&s, &p, world, met, &lost);

        // Walks that have ended: light arrives, and the path scatters or the waiting flight goes on.
        mask walked = (gone | lost) & p.walking;
        mask scatter = walked & ~p.aside;
        if (some(walked)) {
            mask probed = layers_probed(&p, walked, gone);
            next_event_arrive(&p, gone & walked & ~probed);
            flight_start(&p, p.incoming, walked & p.aside);
            p.aside &= ~walked;
            p.walking &= ~walked;
        }

        // Vertices: faint paths play roulette, those that go on ask a light.
        mask dead = (mask)0;
        if (some(vertex)) {
            p.incoming = vector_pick(p.incoming, p.direction, vertex);
            p.inside_there = pick(p.inside_there, p.inside, vertex);
            layers_met(&p, world, surfaces_normal(&s), vertex);
            words v = rng_next(&p.random, vertex);
            real chance = roulette_chance(spectrum_max(p.throughput));
            dead = vertex & test(unit(v.x) >= chance);
            dead |= vertex & surfaces_given_up(&s, (mask)0);
            p.throughput = spectrum_pick(p.throughput, spectrum_scale(p.throughput, 1.f / chance), vertex & ~dead);
            mask asking = vertex & ~dead & (test(p.medium >= 0) | surfaces_scatter_anywhere(&s, world));
            scatter |= vertex & ~dead & ~next_event_start(&p, &s, world, asking);
        }

        // Scattering: a new direction.
        if (some(scatter)) {
            mask in_medium = scatter & test(p.medium >= 0);
            words v = rng_next(&p.random, scatter);
            real weight;
            vector direction = path_scatter(&p, world, v, &weight);
            p.pdf = pick(p.pdf, scatter_pdf(&p, world, direction), in_medium);
            flight_start(&p, direction, in_medium);
            surfaces_scatter(&s, &p, world, scatter & ~in_medium);
            layers_scattered(&p, scatter);
            p.throughput = spectrum_pick(p.throughput, spectrum_scale(p.throughput, weight), in_medium);
            p.order = pick(p.order, p.order + 1, scatter);
            p.asked &= ~scatter;
            dead |= scatter & test(spectrum_max(p.throughput) <= 0.f);
        }

        // End of the path: what lies behind everything, the film, the next sample of the pixel.
        mask leave = gone & flown, end = leave | dead;
        if (some(end)) {
            path_gain(&p, spectrum_multiply(p.throughput, light_escape(world, p.direction, p.pdf)), p.order, leave);
            mask bad = end & surfaces_given_up(&s, end);
            found.unfinished -= bad;
            for (int c = 0; c < CHANNELS; ++c) {
                real value = spectrum_channel(p.radiance, c);
                mask wrong = end & ~bad & ~(test(value >= LEAST) & test(value < INFINITY));
                audit_value(&found, value, wrong);
                bad |= wrong;
            }
            for (int c = 0; c < CHANNELS; ++c)
                moments_add(&sums[c], pick((real)0.f, spectrum_channel(p.radiance, c), end & ~bad));
            for (int k = 0; k < LAYERS; ++k) moments_add(&sums[CHANNELS + k], pick((real)0.f, layer_value(&p, k), end & ~bad));
            live &= ~(end & test(p.random.sample == last));
            p.random.sample = pick(p.random.sample, p.random.sample + 1u, end);
        }
        begin = end & live;
    }

    for (int c = 0; c < PLANES; ++c) moments_store(&sums[PLANE(c)], film + (size_t)(4 * c) * pixels + lane0, pixels);
    audit_store(&found, faults + lane0, pixels);
}
