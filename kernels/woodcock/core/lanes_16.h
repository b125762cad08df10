// Lane types, sixteen lanes (AVX-512).
#define LANES 16
#include "core/lanes_vector.h"
#define lane_index() ((integer)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15))
#define gather(type, p, i) ((LANES_JOIN(type, LANES))((p)[(i).s0], (p)[(i).s1], (p)[(i).s2], (p)[(i).s3], \
                                                      (p)[(i).s4], (p)[(i).s5], (p)[(i).s6], (p)[(i).s7], \
                                                      (p)[(i).s8], (p)[(i).s9], (p)[(i).sa], (p)[(i).sb], \
                                                      (p)[(i).sc], (p)[(i).sd], (p)[(i).se], (p)[(i).sf]))

static inline int some(mask m) {
    int8 c = m.lo | m.hi;
    int4 a = c.lo | c.hi;
    int2 b = a.lo | a.hi;
    return b.x | b.y;
}
#include "core/lanes_math.h"
