// What walks through majorants share. Adds a step to t, compensated (Kahan 1965): t += step stalls for ever once the step
// is below half an ulp of t.
static inline void walk_advance(real *t, real *t_low, real step, mask active) {
    real y = step + *t_low, sum = *t + y;
    *t_low = pick(*t_low, y - (sum - *t), active);
    *t = pick(*t, sum, active);
}
