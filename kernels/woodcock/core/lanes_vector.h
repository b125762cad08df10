// Lane types over OpenCL vectors; lanes_4.h, lanes_8.h and lanes_16.h set LANES, lane_index and gather.
#define LANES_JOIN_(a, b) a##b
#define LANES_JOIN(a, b) LANES_JOIN_(a, b)
typedef float number;
typedef LANES_JOIN(float, LANES) real;
typedef LANES_JOIN(int, LANES) integer;
typedef LANES_JOIN(uint, LANES) word;
typedef LANES_JOIN(int, LANES) mask;
#define to_real(x) LANES_JOIN(convert_float, LANES)(x)
#define to_integer(x) LANES_JOIN(convert_int, LANES)(x)
#define to_word(x) LANES_JOIN(convert_uint, LANES)(x)
#define word_as_integer(x) LANES_JOIN(as_int, LANES)(x)
#define integer_as_word(x) LANES_JOIN(as_uint, LANES)(x)
#define word_as_real(x) LANES_JOIN(as_float, LANES)(x)
#define real_as_word(x) LANES_JOIN(as_uint, LANES)(x)
#define test(condition) (condition)
// Operators rather than the builtins select, any, fmin and fmax: PoCL may call these as functions, spilling all registers.
#define pick(no, yes, chosen) ((chosen) ? (yes) : (no))
#define lanes_store(x, p) LANES_JOIN(vstore, LANES)(x, 0, p)
