// Transmittance by unbiased ray marching: Kettunen, d'Eon, Pantaleoni & Novák, "An unbiased ray-marching transmittance
// estimator", SIGGRAPH 2021. A comb of evenly spaced points, shifted by one uniform, estimates the optical depth τ; exp(-τ) of
// one comb is nearly right, and a power series in the differences of independent combs makes it right:
//   exp(-τ) = E[exp(-τ₀) Σ_k (τ₀ - τ₁) … (τ₀ - τ_k) / k!],
// cut by roulette (Bhanot & Kennedy 1985): nine of ten walks end with the first comb. Every comb is the pivot τ₀ once, the
// products are means over all choices of k others (elementary symmetric means, a U-statistic): the first order then all but
// cancels. Of orders above RAY_MARCHING_ORDER only the first pivot's one product counts, so that they need no memory; none
// is left out. A value may be negative.
//
// Combs are even in the majorant's optical depth, so that no point falls where nothing is.
#include "core/rng.h"

#define RAY_MARCHING_ORDER 7

typedef struct {
    integer order, comb, points, left; // of the series; the comb that is being summed, its points, and those to come
    real spacing;                      // between points, in the majorant's optical depth
    coefficient sum;                   // of σ_t / majorant over the comb
    coefficient depth[RAY_MARCHING_ORDER + 1]; // τ by the first combs
    coefficient product, beyond;       // (τ₀ - τ₁) … of all combs so far; the terms of high order
} ray_marching;

// The number of points for a piece of so much optical depth of the majorant: algorithm 4.
static inline real transmittance_ray_marching_points(real depth) {
    real cube = (0.015f + depth) * (0.65f + depth) * (60.3f + depth);
    return larger(floor(exp(log(cube) * (1.f / 3.f)) * (1.f / 1.31945f) + 0.5f), (real)1.f);
}

// An order is k or more with probability 2^(k - 1) / 10 k!, and with one tenth for k = 1 as for k = 2: algorithm 2. `u` is
// as precise as small probabilities are.
static inline integer transmittance_ray_marching_order(real u) {
    real chance = (real)0.1f;
    mask more = test(u < chance);
    integer order = pick((integer)0, (integer)2, more);
    for (int k = 3; some(more); ++k) {
        chance *= 2.f / (float)k;
        more &= test(u < chance);
        order = pick(order, (integer)k, more);
    }
    return order;
}

// Begins the series of a piece; what has no depth needs one comb.
static inline void transmittance_ray_marching_begin(ray_marching *m, real depth, real u, mask begin) {
    real points = transmittance_ray_marching_points(depth);
    integer order = pick((integer)0, transmittance_ray_marching_order(u), begin & test(depth > 0.f));
    m->order = pick(m->order, order, begin);
    m->comb = pick(m->comb, (integer)0, begin);
    m->points = pick(m->points, to_integer(points), begin);
    m->left = pick(m->left, m->points, begin);
    m->spacing = pick(m->spacing, depth / points, begin);
    m->sum = coefficient_pick(m->sum, coefficient_grey((real)0.f), begin);
    m->product = coefficient_pick(m->product, coefficient_grey((real)1.f), begin);
    m->beyond = coefficient_pick(m->beyond, coefficient_grey((real)0.f), begin);
}

// The majorant's optical depth from here to the next point; `shift`, uniform, is the comb's.
static inline real transmittance_ray_marching_step(const ray_marching *m, real shift) {
    return m->spacing * pick((real)1.f, shift, test(m->left == m->points));
}

static inline void transmittance_ray_marching_meet(ray_marching *m, coefficient sigma_t, real bound, mask event) {
    coefficient sum = coefficient_add(m->sum, coefficient_scale(sigma_t, 1.f / bound));
    m->sum = coefficient_pick(m->sum, sum, event);
    m->left = pick(m->left, m->left - 1, event);
}

// Ends combs; returns lanes that have another to sum up.
static inline mask transmittance_ray_marching_end(ray_marching *m, mask end) {
    coefficient depth = coefficient_scale(m->sum, m->spacing);
    for (int i = 0; i <= RAY_MARCHING_ORDER; ++i)
        m->depth[i] = coefficient_pick(m->depth[i], depth, end & test(m->comb == i));
    // 1 / (k! × probability) of order k is 10 / 2^(k - 1).
    real weight = 20.f * exp(to_real(m->comb) * -0.693147181f);
    mask high = end & test(m->comb > RAY_MARCHING_ORDER);
    for (int c = 0; c < COEFFICIENTS; ++c) {
        real difference = coefficient_channel(m->depth[0], c) - coefficient_channel(depth, c);
        real product = coefficient_channel(m->product, c) * difference, beyond = coefficient_channel(m->beyond, c);
        coefficient_channel(m->product, c) = pick(coefficient_channel(m->product, c), product, end & test(m->comb > 0));
        coefficient_channel(m->beyond, c) = pick(beyond, beyond + weight * product, high);
    }
    m->sum = coefficient_pick(m->sum, coefficient_grey((real)0.f), end);
    m->left = pick(m->left, m->points, end);
    m->comb = pick(m->comb, m->comb + 1, end);
    return end & test(m->comb <= m->order);
}

// The estimate, for lanes whose combs are all there.
static inline real transmittance_ray_marching_channel(const ray_marching *m, int c) {
    real total = exp(-coefficient_channel(m->depth[0], c));
    mask higher = test(m->order > 0);
    if (!some(higher)) return total;
    integer combs = pick(m->order, (integer)RAY_MARCHING_ORDER, test(m->order > RAY_MARCHING_ORDER)) + 1;
    real sum = (real)0.f;
    for (int i = 0; i <= RAY_MARCHING_ORDER && some(higher & test(combs > i)); ++i) {
        real pivot = coefficient_channel(m->depth[i], c), mean[RAY_MARCHING_ORDER + 1] = {(real)1.f};
        int n = 0;
        for (int k = 1; k <= RAY_MARCHING_ORDER; ++k) mean[k] = (real)0.f;
        // Algorithm 1: the means over n others, from those over n - 1.
        for (int j = 0; j <= RAY_MARCHING_ORDER && some(higher & test(combs > j)); ++j) {
            if (j == i) continue;
            ++n;
            real difference = pivot - coefficient_channel(m->depth[j], c);
            for (int k = n; k >= 1; --k) {
                real step = (float)k / (float)n * (mean[k - 1] * difference - mean[k]);
                mean[k] = pick(mean[k], mean[k] + step, test(combs > j));
            }
        }
        real series = (real)1.f;
        float weight = 10.f;
        for (int k = 1; k <= n; ++k, weight *= 0.5f) series += weight * mean[k];
        sum += pick((real)0.f, exp(-pivot) * series, test(combs > i));
    }
    sum = sum / to_real(combs) + total * coefficient_channel(m->beyond, c);
    return pick(total, sum, higher);
}

static inline coefficient transmittance_ray_marching_value(const ray_marching *m) {
    coefficient value;
    for (int c = 0; c < COEFFICIENTS; ++c) coefficient_channel(value, c) = transmittance_ray_marching_channel(m, c);
    return value;
}
