// An orthonormal frame around a unit vector without branches: Duff et al., "Building an Orthonormal Basis, Revisited",
// JCGT 6(1), 2017. Returns x s + y t + z n.
#include "core/vector.h"

static inline vector frame_to_world(vector n, real x, real y, real z) {
    real sign = copysign((real)1.f, n.z), a = -1.f / (sign + n.z), b = n.x * n.y * a;
    vector s = vector_of(1.f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    vector t = vector_of(b, sign + n.y * n.y * a, -n.y);
    return vector_of(x * s.x + y * t.x + z * n.x, x * s.y + y * t.y + z * n.y, x * s.z + y * t.z + z * n.z);
}
