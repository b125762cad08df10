// Absorption only, L = exp(-∫σ_t) L_e: deterministic, one sum per camera ray. Within a cell σ_t is a cubic along the ray,
// whose integral the generated `media_depth` has in closed form: Gauss's two points are exact up to third degree, and both
// lie inside the cell, away from doubts about which side of a plane they are on.
#include "integrator/deterministic.h"

static inline void transmittance(const struct world *world, __global float *film, __global uint *faults, uint first, uint samples) {
    const integer pixel = (integer)(int)((uint)get_global_id(0) * LANES) + lane_index();
    const integer width = (integer)(int)world->scene->film.width, y = pixel / width, x = pixel - y * width;
    moments sums[CHANNELS] = {{0}};
    audit found = {0};

    for (uint sample = first; sample - first < samples; ++sample) {
        camera_path ray = camera_path_of(world, x, y, sample);
        coefficient doubt, depth = media_depth(world, ray.anchor, ray.direction, ray.near, &doubt);
        spectrum light = light_radiance(world, ray.direction);
        mask bad = (mask)0;
        for (int c = 0; c < CHANNELS; ++c) {
            real arriving = spectrum_channel(light, c), value = arriving * exp(-coefficient_channel(depth, c));
            real bound = transmitted_bound(value, arriving, coefficient_channel(doubt, c));
            film_add(&sums[c], value, bound, &found, &bad);
        }
    }
    film_store(sums, &found, film, faults);
}
