// A step under one majorant that passes a control: walks meet tentative collisions at the rate of a bound on what σ_t is
// above it, flights at the majorant's.

// `passed`: the optical depth of the control over the step, of walks.
static inline mask majorant_step_past_control(const struct world *world, majorant_walk *walk, real depth, mask active, mask walks,
                                              coefficient *passed) {
    // A bound of 0, where the control is all there is, leaves any length behind.
    real step = depth * smaller(1.f / walk->bound, (real)1e36f), rest = (walk->far - walk->t) - walk->t_low;
    walk->t_from = pick(walk->t_from, walk->t, active);
    walk_advance(&walk->t, &walk->t_low, step, active);
    mask left = active & ~test(walk->t < walk->far); // so that a NaN leaves, too
    walk->t = pick(walk->t, walk->far, left);
    *passed = coefficient_scale(grids_minorant(world, walk), pick(step, larger(rest, (real)0.f), left));
    return left;
}
