// Absorption and emission, L′ + σ_t L = ε: deterministic, by the exponential integrator of core/exponential.h from the
// camera on, cell by cell. Cells end at the next plane or border of any medium; a step that may be too far off is halved
// until its part of the tolerance holds, so that steps of a cell are aligned fractions of it and add up exactly.
#include "core/depth.h"
#include "core/exponential.h"
#include "integrator/deterministic.h"

// A step over [start, start + width) of the cell, as fractions of its length.
typedef struct { real start, width; } cell_step;

// Radiance that a ray of the camera gathers in the media, its error's bound, the optical depth of what it passed, and how
// many roundings, relatively, these may be off.
static inline void gather_emission(const struct world *world, const camera_path *ray, spectrum *radiance, spectrum *bound, optical_depth *depth, real *doubt) {
    media_walk media;
    real end, from = media_start(world, &media, ray->anchor, ray->direction, ray->near, &end, doubt), to = media_next(&media, from, end);
    const real span = end - from;
    const number tolerance = world->scene->integrator.tolerance;
    cell_step step = {(real)0.f, (real)1.f};
    mask active = test(from < end);

    while (some(active)) {
        real cell = to - from, length = cell * step.width, gain[CHANNELS], error[CHANNELS];
        coefficient sigma[5], passed;
        spectrum epsilon[5];
        for (int j = 0; j < 5; ++j)
            media_coefficients(world, &media, from + cell * (step.start + step.width * exponential_node[j]), &sigma[j], &epsilon[j]);
        mask fine = active, resolved;
        for (int c = 0; c < CHANNELS; ++c) {
            real along_sigma[5], along_epsilon[5];
            for (int j = 0; j < 5; ++j) {
                along_sigma[j] = coefficient_channel(sigma[j], c);
                along_epsilon[j] = spectrum_channel(epsilon[j], c);
            }
            coefficient_channel(passed, c) = exponential_step(along_sigma, along_epsilon, length, &gain[c], &error[c], &resolved);
            real through = exp(-coefficient_channel(depth->sum, c));
            gain[c] = through * larger(gain[c], (real)0.f);
            error[c] = pick(larger(gain[c], through * error[c]), through * error[c], resolved);
            // Half of the tolerance is shared by what steps gain, half by how long they are.
            real allowed = 0.5f * tolerance * (gain[c] + spectrum_channel(*radiance, c) * length / span);
            fine &= resolved & test(error[c] <= allowed);
        }
        mask accept = active & (fine | test(step.width <= larger(step.start * SMALLEST_STEP, (real)0x1p-64f)));
        for (int c = 0; c < CHANNELS; ++c) {
            spectrum_channel(*radiance, c) += pick((real)0.f, gain[c], accept);
            spectrum_channel(*bound, c) += pick((real)0.f, error[c], accept);
        }
        optical_depth_add(depth, coefficient_pick(coefficient_grey((real)0.f), passed, accept));

        // The next step: half as long, or on; twice as long where it is aligned; or the next cell.
        real start = pick(step.start, step.start + step.width, accept), doubled = start / (2.f * step.width);
        mask even = accept & test(floor(doubled) == doubled);
        step.width *= pick(pick((real)0.5f, (real)1.f, accept), (real)2.f, even);
        step.start = start;
        mask over = accept & test(start >= 1.f);
        if (some(over)) {
            media_pass(world, &media, to, over);
            from = pick(from, to, over);
            to = pick(to, media_next(&media, from, end), over);
            step.start = pick(step.start, (real)0.f, over);
            step.width = pick(step.width, (real)1.f, over);
            active &= ~over | test(from < end);
        }
        active &= optical_depth_is_finite(depth);
    }
}

static inline void emission_absorption(const struct world *world, __global float *film, __global uint *faults, uint first, uint samples) {
    const integer pixel = (integer)(int)((uint)get_global_id(0) * LANES) + lane_index();
    const integer width = (integer)(int)world->scene->film.width, y = pixel / width, x = pixel - y * width;
    moments sums[CHANNELS] = {{0}};
    integer rejected = (integer)0;

    for (uint sample = first; sample - first < samples; ++sample) {
        camera_path ray = camera_path_of(world, x, y, sample);
        spectrum radiance = spectrum_grey((real)0.f), bound = radiance, light = light_radiance(world, ray.direction);
        optical_depth depth = {coefficient_grey((real)0.f), coefficient_grey((real)0.f)};
        real doubt;
        gather_emission(world, &ray, &radiance, &bound, &depth, &doubt);
        mask bad = (mask)0;
        for (int c = 0; c < CHANNELS; ++c) {
            real arriving = spectrum_channel(light, c), tau = coefficient_channel(depth.sum, c);
            real through = arriving * exp(-tau), gathered = spectrum_channel(radiance, c);
            real off = spectrum_channel(bound, c) + gathered * (4.f + doubt) * EPSILON;
            film_add(&sums[c], gathered + through, off + transmitted_bound(through, arriving, tau * doubt), &bad);
        }
        rejected -= bad;
    }
    film_store(sums, rejected, film, faults);
}
