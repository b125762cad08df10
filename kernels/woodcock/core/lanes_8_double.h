// Lane types in double precision, eight lanes (AVX-512).
#define LANES 8
#include "core/lanes_vector_double.h"
#define lane_index() ((integer)(0, 1, 2, 3, 4, 5, 6, 7))
#define gather(type, p, i) ((lanes_gathered(type))((p)[(i).s0], (p)[(i).s1], (p)[(i).s2], (p)[(i).s3], \
                                                   (p)[(i).s4], (p)[(i).s5], (p)[(i).s6], (p)[(i).s7]))

static inline int some(mask m) {
    long4 a = m.lo | m.hi;
    long2 b = a.lo | a.hi;
    return (b.x | b.y) != 0;
}
#include "core/lanes_math.h"
