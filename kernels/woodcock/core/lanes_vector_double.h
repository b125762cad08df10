// Lane types over OpenCL vectors of doubles: the vocabulary of lanes_vector.h, with integers, words and masks as wide as
// the reals, so that the same code runs in double precision. `number` is double: so are all members of a scene's record.
// Buffers keep their types and are widened by `gather`. A word's bits are still those of a float, and a float's suffix
// on a literal says nothing: what is written 0.5f is exact.
#define LANES_JOIN_(a, b) a##b
#define LANES_JOIN(a, b) LANES_JOIN_(a, b)
typedef double number;
typedef LANES_JOIN(double, LANES) real;
typedef LANES_JOIN(long, LANES) integer;
typedef LANES_JOIN(ulong, LANES) word;
typedef LANES_JOIN(long, LANES) mask;
#define lanes_wide_float double
#define lanes_wide_int long
#define lanes_wide_uint ulong
#define lanes_wide_ushort ushort
#define lanes_wide_uchar uchar
#define lanes_gathered(type) LANES_JOIN(LANES_JOIN(lanes_wide_, type), LANES)
#define to_real(x) LANES_JOIN(convert_double, LANES)(x)
#define to_integer(x) LANES_JOIN(convert_long, LANES)(x)
#define to_word(x) LANES_JOIN(convert_ulong, LANES)(x)
#define word_as_integer(x) LANES_JOIN(as_long, LANES)(x)
#define integer_as_word(x) LANES_JOIN(as_ulong, LANES)(x)
#define word_as_real(x) to_real(LANES_JOIN(as_float, LANES)(LANES_JOIN(convert_uint, LANES)(x)))
#define real_as_word(x) LANES_JOIN(as_uint, LANES)(LANES_JOIN(convert_float, LANES)(x))
#define test(condition) (condition)
#define pick(no, yes, chosen) ((chosen) ? (yes) : (no))
#define lanes_store(x, p) LANES_JOIN(vstore, LANES)(x, 0, p)
#define lanes_as_float(x) to_real(LANES_JOIN(convert_float, LANES)(x))
#define lanes_store_float(x, p) LANES_JOIN(vstore, LANES)(LANES_JOIN(convert_float, LANES)(x), 0, p)
#define lanes_store_uint(x, p) LANES_JOIN(vstore, LANES)(LANES_JOIN(convert_uint, LANES)(x), 0, p)
