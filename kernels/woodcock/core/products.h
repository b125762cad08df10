// Differences of products to one and a half ulp, their signs exact, and what is built of them: Kahan's algorithm by fused
// multiply-add, with the error bound of Jeannerod, Louvet & Muller, Mathematics of Computation 82, 2013.
#include "core/vector.h"

// a b - c d
static inline real difference_of_products(real a, real b, real c, real d) {
    real cd = c * d;
    return fma(a, b, -cd) + fma(-c, d, cd);
}

static inline vector vector_cross(vector a, vector b) {
    return vector_of(difference_of_products(a.y, b.z, a.z, b.y), difference_of_products(a.z, b.x, a.x, b.z),
                     difference_of_products(a.x, b.y, a.y, b.x));
}
