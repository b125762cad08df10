// Storage of a grid that needs all of single precision.
typedef float density_storage;
static inline real density_fetch(__global const density_storage *p, integer i) { return gather(float, p, i); }
