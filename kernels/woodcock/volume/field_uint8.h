// Storage of a field in bytes, 0 to 255 steps.
static inline real field_uint8(__global const uchar *p, integer i) { return to_real(gather(uchar, p, i)); }
