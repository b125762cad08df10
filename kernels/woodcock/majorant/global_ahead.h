// How much optical depth of the one majorant lies ahead, and walks that begin again: for combs of evenly spaced points.
static inline real majorant_ahead(const struct world *world, majorant_walk walk, real most, mask walking) {
    return smaller(walk.bound * larger((walk.far - walk.t) - walk.t_low, (real)0.f), most);
}

static inline void majorant_restore(majorant_walk *walk, const majorant_walk *from, mask chosen) {
    walk->t = pick(walk->t, from->t, chosen);
    walk->t_low = pick(walk->t_low, from->t_low, chosen);
    walk->t_from = pick(walk->t_from, from->t_from, chosen);
    walk->far = pick(walk->far, from->far, chosen);
    walk->bound = pick(walk->bound, from->bound, chosen);
}
