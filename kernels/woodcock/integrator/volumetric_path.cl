// The volume rendering equation with scattering, L = L0 + K L0 + K² L0 + …, by tracing paths from the camera.
// A lane is one path of its own pixel; one whose path ends starts its pixel's next sample at once.
#include "core/audit.h"
#include "core/box.h"
#include "core/moments.h"
#include "core/path.h"
#include "core/roulette.h"

// The camera ray of the path's sample, from where it enters the volume; one that misses gets an exit behind it.
static inline void path_begin(path *p, const struct world *world, integer x, integer y, mask begin) {
    p->random.dimension = pick(p->random.dimension, (word)0u, begin);
    words w = rng_next(&p->random, begin);
    int width = world->scene->film.width, height = world->scene->film.height;
    vector anchor, direction;
    real near, far = (real)1e30f;
    camera_ray(world, (to_real(x) + unit(w.x)) / (float)width, (to_real(y) + unit(w.y)) / (float)height, &anchor, &direction, &near);
    vector local_anchor = affine_point(volume_to_local(world), anchor), along = affine_direction(volume_to_local(world), direction);
    box_clip(volume_size(world), local_anchor, along, &near, &far);
    p->origin = vector_pick(p->origin, vector_along(local_anchor, near, along), begin);
    p->direction = vector_pick(p->direction, direction, begin);
    p->along = vector_pick(p->along, along, begin);
    p->t_exit = pick(p->t_exit, far - near, begin);
    p->throughput = spectrum_pick(p->throughput, spectrum_grey((real)1.f), begin);
    p->radiance = spectrum_pick(p->radiance, spectrum_grey((real)0.f), begin);
    p->order = pick(p->order, (integer)0, begin);
}

static inline void volumetric_path(const struct world *world, __global float *film, __global uint *faults, uint first, uint samples, integer pixel) {
    const uint lane0 = get_global_id(0) * LANES, pixels = get_global_size(0) * LANES;
    const int width = world->scene->film.width;
    const integer y = pixel / width, x = pixel - y * width;
    const spectrum albedo = volume_albedo(world);

    // Every lane starts its pixel's first sample; paths and flights start at one place, which is inlined.
    path p = {{(word)0u}};
    flight f = {0};
    p.random.pixel = integer_as_word(pixel);
    p.random.sample = (word)first;
    p.random.dimension = (word)0u;
    p.random.seed = world->scene->film.seed;
    mask live = (mask)-1, begin = live, fresh = live;
    next_event event = {0};
    moments sums[CHANNELS] = {{0}};
    audit found = {0};
    const word last = (word)(first + samples - 1u);

    while (some(live)) {
        if (some(begin)) path_begin(&p, world, x, y, begin);
        if (some(fresh)) flight_start(&f, &p, world, fresh);
        begin = fresh = (mask)0;

        // Tentative collision, of a flight or of a shadow walk.
        words w = rng_next(&p.random, (mask)-1);
        real u, depth = rng_flight(&p.random, w, &u);
        mask escape = flight_step(&f, &p, world, depth);
        vector at = vector_along(p.origin, pick(p.t, p.t_exit, escape), p.along);
        real density = flight_density(&f, world, at, w);
        audit_majorant(&found, density, spectrum_max(p.throughput), live & ~escape & test(density > 1.000001f));
        mask flying = live & ~next_event_walking(&event);
        mask collide = free_flight_collides(density, u) & ~escape & flying;
        mask leave = escape & flying;
        mask scatter = next_event_step(&event, world, &p, density, escape, u);
        if (!some(collide | leave | scatter)) continue;

        // Collision: absorb by weight; faint paths play roulette.
        words v = rng_next(&p.random, collide | leave | scatter);
        p.throughput = spectrum_pick(p.throughput, spectrum_multiply(p.throughput, albedo), collide);
        real chance = roulette_chance(spectrum_max(p.throughput));
        mask dead = collide & test(unit(v.x) >= chance);
        p.throughput = spectrum_pick(p.throughput, spectrum_scale(p.throughput, 1.f / chance), collide & ~dead);
        p.origin = vector_pick(p.origin, at, collide);
        scatter |= next_event_start(&event, world, &p, collide & ~dead, unit(v.y), u / density);

        // Scattering: a new direction.
        vector direction = path_scatter(&p, world, v, scatter);
        p.direction = vector_pick(p.direction, direction, scatter);
        p.along = vector_pick(p.along, affine_direction(volume_to_local(world), p.direction), scatter);
        fresh = collide | scatter;
        p.t_exit = pick(p.t_exit, flight_exit(world, &p), fresh);

        // End of the path: the environment, the film, the next sample of the pixel.
        mask end = leave | dead;
        if (some(end)) {
            spectrum sky = spectrum_multiply(p.throughput, light_radiance(world, p.direction));
            spectrum total = spectrum_pick(p.radiance, spectrum_add(p.radiance, sky), leave);
            mask bad = (mask)0;
            for (int c = 0; c < CHANNELS; ++c) {
                real value = spectrum_channel(total, c);
                mask wrong = end & ~bad & ~(test(value >= 0.f) & test(value < INFINITY));
                audit_value(&found, value, wrong);
                bad |= wrong;
            }
            for (int c = 0; c < CHANNELS; ++c)
                moments_add(&sums[c], pick((real)0.f, spectrum_channel(total, c), end & ~bad));
            live &= ~(end & test(p.random.sample == last));
            p.random.sample = pick(p.random.sample, p.random.sample + 1u, end);
            begin = end;
            fresh |= end;
        }
    }

    for (int c = 0; c < CHANNELS; ++c) moments_store(&sums[c], film + (size_t)(4 * c) * pixels + lane0, pixels);
    audit_store(&found, faults + lane0, pixels);
}
