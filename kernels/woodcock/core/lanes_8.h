// Lane types, eight lanes (AVX).
#define LANES 8
#include "core/lanes_vector.h"
#define lane_index() ((integer)(0, 1, 2, 3, 4, 5, 6, 7))
#define gather(type, p, i) ((LANES_JOIN(type, LANES))((p)[(i).s0], (p)[(i).s1], (p)[(i).s2], (p)[(i).s3], \
                                                      (p)[(i).s4], (p)[(i).s5], (p)[(i).s6], (p)[(i).s7]))

static inline int some(mask m) {
    int4 a = m.lo | m.hi;
    int2 b = a.lo | a.hi;
    return b.x | b.y;
}
#include "core/lanes_math.h"
