// Next-event estimation as a second mode of a lane: from a collision the lane walks towards a light, by the steps of a
// free flight, and scatters on arrival. The vertex is the walk's origin: nothing needs restoring.
#include "core/roulette.h"

typedef struct {
    mask walking;
    real transmittance;
    vector towards;
    spectrum weight; // what arrives if nothing is lost
} next_event;

static inline mask next_event_walking(const next_event *event) { return event->walking; }

// One step of the walks; returns lanes that have arrived or lost all weight, and scatter now.
static inline mask next_event_step(next_event *event, const struct world *world, path *p, real density, mask escape, real u) {
    real transmittance = event->transmittance;
    mask over = transmittance_step(world, &transmittance, density, p->t_exit, escape, u) & event->walking;
    event->transmittance = pick(event->transmittance, transmittance, event->walking);
    if (some(over)) {
        spectrum light = spectrum_scale(event->weight, transmittance);
        p->radiance = spectrum_pick(p->radiance, spectrum_add(p->radiance, light), over);
        event->walking &= ~over;
    }
    return over;
}

// Sends lanes that have collided towards a light; the others scatter at once. `odds`, uniform in (0, 1], decides.
static inline mask next_event_start(next_event *event, const struct world *world, path *p, mask collide, real u, real odds) {
    spectrum weight;
    vector towards = light_sample(world, u, &weight);
    real phase = phase_eval(world, p->direction, towards), chance = roulette_walk(phase);
    mask walk = collide & test(odds <= chance);
    weight = spectrum_scale(spectrum_multiply(weight, p->throughput), phase / chance);
    event->towards = vector_pick(event->towards, towards, walk);
    event->weight = spectrum_pick(event->weight, weight, walk);
    event->transmittance = pick(event->transmittance, (real)1.f, walk);
    event->walking |= walk;
    p->along = vector_pick(p->along, affine_direction(volume_to_local(world), towards), walk);
    return collide & ~walk;
}
