// What a kernel finds amiss in its own work: samples that are no radiance, by what they are, and tentative collisions where σ_t
// exceeded its majorant: how many, the throughput of the paths that they befell, and by which factor at most.
#include "core/vector.h"

typedef struct {
    integer nan, infinite, negative, unfinished, violations;
    real touched, excess;
} audit;

// Counts values that are no radiance. There are none, as a rule: nothing but the question costs time.
static inline void audit_value(audit *a, real value, mask bad) {
    if (!some(bad)) return;
    mask nan = bad & test(value != value), negative = bad & test(value < 0.f);
    a->nan -= nan;
    a->negative -= negative;
    a->infinite -= bad & ~(nan | negative);
}

// Counts collisions with a σ_t of `excess` majorants.
static inline void audit_majorant(audit *a, real excess, real throughput, mask violated) {
    if (!some(violated)) return;
    a->violations -= violated;
    a->touched += pick((real)0.f, throughput, violated);
    a->excess = pick(a->excess, larger(a->excess, excess), violated);
}

// Seven planes of one number a lane.
static inline void audit_store(const audit *a, __global uint *faults, size_t plane) {
    store_count(a->nan, faults);
    store_count(a->infinite, faults + plane);
    store_count(a->negative, faults + 2 * plane);
    store_count(a->unfinished, faults + 3 * plane);
    store_count(a->violations, faults + 4 * plane);
    store_bits(a->touched, faults + 5 * plane);
    store_bits(a->excess, faults + 6 * plane);
}
