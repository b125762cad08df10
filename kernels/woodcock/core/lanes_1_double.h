// Lane types in double precision, one lane: see lanes_vector_double.h. Words are those of floats, so that random numbers are
// the same ones.
#define LANES 1
typedef double real, number;
typedef int integer;
typedef uint word;
typedef int mask;
#define to_real(x) ((double)(x))
#define to_integer(x) ((int)(x))
#define to_word(x) ((uint)(x))
#define word_as_integer(x) as_int(x)
#define integer_as_word(x) as_uint(x)
#define word_as_real(x) ((double)as_float(x))
#define real_as_word(x) as_uint((float)(x))
#define test(condition) (-(int)(condition))
#define pick(no, yes, chosen) ((chosen) ? (yes) : (no))
#define some(m) (m)
#define lane_index() 0
#define gather(type, p, i) ((p)[i])
#define lanes_store(x, p) (*(p) = (x))
#define lanes_as_float(x) ((double)(float)(x))
#define lanes_store_float(x, p) (*(p) = (float)(x))
#define lanes_store_uint(x, p) (*(p) = (uint)(x))
#include "core/lanes_math.h"
