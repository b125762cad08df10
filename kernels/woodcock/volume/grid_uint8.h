// Storage of a grid whose values are integers from 0 to 255.
typedef uchar density_storage;
static inline real density_fetch(__global const density_storage *p, integer i) { return to_real(gather(uchar, p, i)); }
