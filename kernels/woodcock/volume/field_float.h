// Storage of a field that needs all of single precision.
static inline real field_float(__global const float *p, integer i) { return to_real(gather(float, p, i)); }
