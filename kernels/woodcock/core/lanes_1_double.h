// Lane types in double precision, one lane. See lanes_vector_double.h.
#define LANES 1
typedef double real, number;
typedef long integer;
typedef ulong word;
typedef long mask;
#define to_real(x) ((double)(x))
#define to_integer(x) ((long)(x))
#define to_word(x) ((ulong)(x))
#define word_as_integer(x) as_long(x)
#define integer_as_word(x) as_ulong(x)
#define word_as_real(x) ((double)as_float((uint)(x)))
#define test(condition) (-(long)(condition))
#define pick(no, yes, chosen) ((chosen) ? (yes) : (no))
#define some(m) (m)
#define lane_index() 0
#define gather(type, p, i) ((p)[i])
#define lanes_store(x, p) (*(p) = (x))
#define lanes_as_float(x) ((double)(float)(x))
#define lanes_store_float(x, p) (*(p) = (float)(x))
#define lanes_store_uint(x, p) (*(p) = (uint)(x))
#include "core/lanes_math.h"
