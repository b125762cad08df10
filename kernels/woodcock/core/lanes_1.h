// Lane types, one lane: plain scalars, for GPUs and for the definition that the wider ones are tested against.
// A mask is all ones where true and 0 where false at every width, so &, | and ~ mean the same everywhere.
#define LANES 1
typedef float real, number;
typedef int integer;
typedef uint word;
typedef int mask;
#define to_real(x) ((float)(x))
#define to_integer(x) ((int)(x))
#define word_as_integer(x) as_int(x)
#define integer_as_word(x) as_uint(x)
#define word_as_real(x) as_float(x)
#define real_as_word(x) as_uint(x)
#define test(condition) (-(int)(condition))
#define pick(no, yes, chosen) ((chosen) ? (yes) : (no))
#define some(m) (m)
#define lane_index() 0
#define gather(type, p, i) ((p)[i])
#define to_word(x) ((uint)(x))
#define lanes_store(x, p) (*(p) = (x))
#include "core/lanes_math.h"
