// Absorption and emission, L′ + σ_t L = ε: deterministic, by the exponential integrator of core/exponential.h from the
// camera on, cell by cell. Cells end at the next plane or border of any medium; a step that may be too far off is halved
// until its part of the tolerance holds, so that steps of a cell are aligned fractions of it and add up exactly.
#include "core/depth.h"
#include "core/exponential.h"
#include "integrator/deterministic.h"

// A step over [start, start + width) of the cell, as fractions of its length.
typedef struct { real start, width; } cell_step;

// What a ray of the camera gathers in the media.
typedef struct {
    spectrum radiance, bound;  // of its error
    optical_depth depth;       // of what it passed
    real doubt;                // how many roundings these may be off, relatively
} gathered;

// Lanes where what lies ahead may still add to the radiance by more than it is rounded by, in some channel. No medium and no
// light gives more than 1 in the device's units (space.py), and a scene has 8 and 64 of them at most.
static inline mask more_is_seen(const gathered *found, spectrum known) {
    mask seen = (mask)0;
    for (int c = 0; c < CHANNELS; ++c) {
        real through = exp(-coefficient_channel(found->depth.sum, c));
        real sure = larger(spectrum_channel(known, c), spectrum_channel(found->radiance, c));
        seen |= test(through > 0.f) & test(72.f * through > EPSILON * sure);
    }
    return seen;
}

// known: radiance that arrives at least, so that what hardly adds to it takes no small steps.
static inline void gather_emission(const struct world *world, const camera_path *ray, number tolerance, spectrum known, gathered *found) {
    found->radiance = found->bound = spectrum_grey((real)0.f);
    found->depth.sum = found->depth.rest = coefficient_grey((real)0.f);
    media_walk media;
    real end, from = media_start(world, &media, ray->anchor, ray->direction, ray->near, &end, &found->doubt);
    real to = media_next(&media, from, end);
    const real span = end - from;
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
            real through = exp(-coefficient_channel(found->depth.sum, c));
            gain[c] = through * larger(gain[c], (real)0.f);
            error[c] = pick(larger(gain[c], through * error[c]), through * error[c], resolved);
            // Half of the tolerance is shared by what steps gain, half by how long they are.
            real sure = larger(spectrum_channel(known, c), spectrum_channel(found->radiance, c));
            real allowed = 0.5f * tolerance * (gain[c] + sure * (length / span));
            fine &= resolved & test(error[c] <= allowed);
        }
        mask accept = active & (fine | test(step.width <= larger(step.start * SMALLEST_STEP, (real)0x1p-64f)));
        for (int c = 0; c < CHANNELS; ++c) {
            spectrum_channel(found->radiance, c) += pick((real)0.f, gain[c], accept);
            spectrum_channel(found->bound, c) += pick((real)0.f, error[c], accept);
        }
        optical_depth_add(&found->depth, coefficient_pick(coefficient_grey((real)0.f), passed, accept));

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
        active &= more_is_seen(found, known);
    }
}

static inline void emission_absorption(const struct world *world, __global float *film, __global uint *faults, uint first, uint samples) {
    const integer pixel = (integer)(int)((uint)get_global_id(0) * LANES) + lane_index();
    const integer width = (integer)(int)world->scene->film.width, y = pixel / width, x = pixel - y * width;
    moments sums[CHANNELS] = {{0}};
    audit amiss = {0};

    // No smaller than what rounding leaves of the rules' differences.
    const number asked = world->scene->integrator.tolerance, least = 1024 * EPSILON;

    for (uint sample = first; sample - first < samples; ++sample) {
        camera_path ray = camera_path_of(world, x, y, sample);
        spectrum light = light_radiance(world, ray.direction), known = spectrum_grey((real)0.f), value, bound;
        mask bad = (mask)0;
        // First roughly, to know what matters.
        for (int rough = 1; rough >= 0; --rough) {
            gathered found;
            gather_emission(world, &ray, rough && asked < 0.1f ? 0.1f : asked > least ? asked : least, known, &found);
            for (int c = 0; c < CHANNELS; ++c) {
                real arriving = spectrum_channel(light, c), tau = coefficient_channel(found.depth.sum, c);
                real through = arriving * exp(-tau), own = spectrum_channel(found.radiance, c);
                real off = spectrum_channel(found.bound, c) + own * (5.f + found.doubt) * EPSILON;
                spectrum_channel(value, c) = own + through;
                spectrum_channel(bound, c) = off + transmitted_bound(through, arriving, tau * found.doubt);
                spectrum_channel(known, c) = larger(spectrum_channel(value, c) - spectrum_channel(bound, c), (real)0.f);
            }
        }
        for (int c = 0; c < CHANNELS; ++c) film_add(&sums[c], spectrum_channel(value, c), spectrum_channel(bound, c), &amiss, &bad);
    }
    film_store(sums, &amiss, film, faults);
}
