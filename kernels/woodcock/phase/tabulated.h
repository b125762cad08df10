// Any phase function, piecewise linear in cos θ. The table is kept as two, one from each pole to the equator, in the versine
// from that pole, which grows from 0 to 1: peaks at either pole keep their digits. `value` is p at the nodes, `cumulative` the
// probability from the pole up to each.
#include "core/warp.h"

// The last node from `low` on, but not `high` itself, whose key is not above `key`; low's must not be.
static inline integer phase_tabulated_find(__global const float *keys, integer low, integer high, real key) {
    while (some(test(high - low > 1))) {
        integer middle = (low + high) >> 1;
        mask below = test(gather(float, keys, middle) <= key);
        // A lane that is done has middle == low, whose key is below.
        low = pick(low, middle, below);
        high = pick(middle, high, below);
    }
    return low;
}

static inline real phase_tabulated_eval(__constant const struct phase_tabulated *phase, __global const float *versine,
                                        __global const float *value, __global const float *cumulative, vector in, vector out) {
    mask forward = test(vector_dot(in, out) > 0.f);
    vector chord = vector_along(in, pick((real)1.f, (real)-1.f, forward), out);
    // Below 1, the last node's, so that the node found is left of it and the next truly right: no width vanishes.
    real x = smaller(0.5f * vector_dot(chord, chord), (real)0x1.fffffep-1f);
    integer low = pick((integer)phase->backward_first, (integer)phase->forward_first, forward);
    integer high = pick((integer)phase->backward_last, (integer)phase->forward_last, forward);
    integer i = phase_tabulated_find(versine, low, high, x);
    real x0 = gather(float, versine, i), x1 = gather(float, versine, i + 1);
    // Not p0 + t (p1 - p0), which would lose a small p1 beside a large p0.
    return (gather(float, value, i) * (x1 - x) + gather(float, value, i + 1) * (x - x0)) / (x1 - x0);
}

// Between two nodes the distribution function is quadratic; with t its share there and s that of the way,
// s = t (p0 + p1) / (p0 + √(p0² (1 - t) + p1² t)), in which nothing cancels.
static inline vector phase_tabulated_sample(__constant const struct phase_tabulated *phase, __global const float *versine,
                                            __global const float *value, __global const float *cumulative, vector in,
                                            real u, real v) {
    mask forward = test(u >= phase->backward);
    // Below the last node's, so that the step found has a probability.
    real w = smaller(pick(u, 1.f - u, forward), pick((real)phase->backward_most, (real)phase->forward_most, forward));
    integer low = pick((integer)phase->backward_first, (integer)phase->forward_first, forward);
    integer high = pick((integer)phase->backward_last, (integer)phase->forward_last, forward);
    integer i = phase_tabulated_find(cumulative, low, high, w);
    real c0 = gather(float, cumulative, i), c1 = gather(float, cumulative, i + 1);
    real t = (w - c0) / (c1 - c0), rest = (c1 - w) / (c1 - c0);
    real p0 = gather(float, value, i), p1 = gather(float, value, i + 1), most = larger(p0, p1);
    p0 /= most;  // squares of any p stay in range
    p1 /= most;
    real s = t * (p0 + p1) / larger(p0 + sqrt(p0 * p0 * rest + p1 * p1 * t), (real)1e-30f);
    real x0 = gather(float, versine, i), x1 = gather(float, versine, i + 1), side = pick((real)-1.f, (real)1.f, forward);
    return warp_around(vector_of(in.x * side, in.y * side, in.z * side), smaller(x0 + (x1 - x0) * s, (real)1.f), v);
}

static inline real phase_tabulated_pdf(__constant const struct phase_tabulated *phase, __global const float *versine,
                                       __global const float *value, __global const float *cumulative, vector in, vector out) {
    return phase_tabulated_eval(phase, versine, value, cumulative, in, out);
}
