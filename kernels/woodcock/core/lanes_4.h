// Lane types, four lanes (SSE, NEON).
#define LANES 4
#include "core/lanes_vector.h"
#define lane_index() ((integer)(0, 1, 2, 3))
#define gather(type, p, i) ((LANES_JOIN(type, LANES))((p)[(i).s0], (p)[(i).s1], (p)[(i).s2], (p)[(i).s3]))

static inline int some(mask m) {
    int2 b = m.lo | m.hi;
    return b.x | b.y;
}
#include "core/lanes_math.h"
