// Storage of a field in half floats, 0 or more. Widened by integer arithmetic: exact, subnormals too, and without the
// cl_khr_fp16 extension or the device's own treatment of subnormals.
static inline real field_half(__global const ushort *p, integer i) {
    word bits = to_word(gather(ushort, p, i)) << 13u;
    real normal = word_as_real(bits + (112u << 23u)), subnormal = word_as_real(bits + (113u << 23u)) - word_as_real((word)(113u << 23u));
    return pick(normal, subnormal, test(bits < (1u << 23u)));
}
