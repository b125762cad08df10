// Lane types in double precision, four lanes (AVX2).
#define LANES 4
#include "core/lanes_vector_double.h"
#define lane_index() ((integer)(0, 1, 2, 3))
#define gather(type, p, i) ((lanes_gathered(type))((p)[(i).s0], (p)[(i).s1], (p)[(i).s2], (p)[(i).s3]))

static inline int some(mask m) {
    long2 b = m.lo | m.hi;
    return (b.x | b.y) != 0;
}
#include "core/lanes_math.h"
