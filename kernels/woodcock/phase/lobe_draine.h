// A Draine lobe by its numbers, for every phase function that is made of such: Henyey–Greenstein × (base + square cos² θ),
// with base = 1 / N and square = α / N from the host, so that no α overflows.
#include "phase/lobe_henyey_greenstein.h"

static inline real lobe_draine_at(number g, number gap, number base, number square, vector in, vector out) {
    real cosine = vector_dot(in, out);
    return lobe_henyey_greenstein_at(g, gap, in, out) * (base + square * cosine * cosine);
}

// The closed inverse of the distribution function (Jendersie & d'Eon 2023) takes cube roots of differences and divides by
// g; here it is found by Newton's steps instead, kept in a bracket. The unknown h is the share that the Henyey–Greenstein
// lobe alone has from a pole on. With g signed so that it is positive towards that pole and gap = 1 - g,
//     cos θ = 1 - y (gap + g y / 2) there, 0 <= y <= 2, with h = (1 + g) y / 2 (gap + g y), and Draine's share is
//     h (base + square ((1 - gap y / 2)² + gap (gap + g y) y² / 12)), which grows by base + square cos² θ per h:
// sums of positive terms alone. Lanes begin at the pole that is nearer by share, where small shares keep their digits.
static inline vector lobe_draine_around(number g, number gap, number base, number square, vector in, real u, real v) {
    number size = fabs(g);
    mask backward = test(u < 0.5f);
    real wanted = pick(1.f - u, u, backward);
    real towards = pick((real)size, (real)-size, backward);
    real near = pick((real)gap, (real)(1.f + size), backward);
    real far = pick((real)(1.f + size), (real)gap, backward);
    real h = wanted, low = (real)0.f, high = (real)1.f;
    mask active = (mask)-1;
    // Three steps suffice for α = 1; sixteen for any, where the density almost vanishes at the root.
    for (int step = 0; step < 16 && some(active); ++step) {
        real y = 2.f * near * h / larger(far - 2.f * towards * h, (real)1e-30f), across = 1.f - 0.5f * near * y;
        real mean = across * across + near * (near + towards * y) * y * y * 0.0833333333f;  // of cos² θ up to here
        real error = h * (base + square * mean) - wanted;
        real cosine = 1.f - y * (near + 0.5f * towards * y);
        active &= test(fabs(error) > 6e-7f * wanted);
        low = pick(low, h, test(error < 0.f));
        high = pick(high, h, test(error > 0.f));
        real next = h - error / larger(base + square * cosine * cosine, (real)1e-30f);
        next = pick(0.5f * (low + high), next, test(next > low) & test(next < high));
        h = pick(h, next, active);
    }
    real from_back = pick(1.f - h, h, backward), from_peak = pick(h, 1.f - h, backward);
    return lobe_henyey_greenstein_around((real)g, (real)gap, in, from_back, from_peak, v);
}
