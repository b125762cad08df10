// Next-event estimation as a second mode of a lane: from a collision the lane walks towards a light, by the steps of a
// free flight, and scatters on arrival. The vertex is the walk's origin: nothing needs restoring.
typedef struct {
    mask walking;
    real transmittance;
    vector towards;
    spectrum weight;
} next_event;

static inline mask next_event_walking(const next_event *event) { return event->walking; }

// One step of the walks; returns lanes that have arrived or lost all weight, and scatter now.
static inline mask next_event_step(next_event *event, const struct world *world, path *p, real density, mask escape, real u) {
    real transmittance = event->transmittance;
    mask over = transmittance_step(world, &transmittance, density, p->t_exit, escape, u) & event->walking;
    event->transmittance = pick(event->transmittance, transmittance, event->walking);
    if (some(over)) {
        real phase = phase_eval(world, p->direction, event->towards);
        spectrum light = spectrum_scale(spectrum_multiply(event->weight, p->throughput), phase * transmittance);
        p->radiance = spectrum_pick(p->radiance, spectrum_add(p->radiance, light), over);
        event->walking &= ~over;
    }
    return over;
}

// Sends lanes that have collided towards a light; none scatters yet.
static inline mask next_event_start(next_event *event, const struct world *world, path *p, mask collide, real u) {
    spectrum weight;
    vector towards = light_sample(world, u, &weight);
    event->towards = vector_pick(event->towards, towards, collide);
    event->weight = spectrum_pick(event->weight, weight, collide);
    event->transmittance = pick(event->transmittance, (real)1.f, collide);
    event->walking |= collide;
    p->along = vector_pick(p->along, affine_direction(volume_to_local(world), towards), collide);
    return (mask)0;
}
