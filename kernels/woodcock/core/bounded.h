// The sum of a pixel's values, compensated, and of bounds on their errors, in place of squares: as pairs of floats in the
// film's planes, the sum in the first two of a channel and the bounds in the last two.
#include "core/moments.h"

static inline void bounded_add(moments *m, real value, real bound) {
    pair_add(&m->sum, &m->sum_low, value, (real)0.f);
    pair_add(&m->square, &m->square_low, bound, (real)0.f);
}
