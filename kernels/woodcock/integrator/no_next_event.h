// Next-event estimation in a scene whose lights are all met on escape: a collision scatters at once.
typedef struct { int unused; } next_event;

static inline mask next_event_walking(const next_event *event) { return (mask)0; }

static inline mask next_event_step(next_event *event, const struct world *world, path *p, real density, mask escape, real u) {
    return (mask)0;
}

static inline mask next_event_start(next_event *event, const struct world *world, path *p, mask collide, real u, real odds) {
    return collide;
}
