// Triangles, three corners each: Woop, Benthin & Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. Their edge
// functions fall back to float64 where they vanish; differences of products by fused multiply-add have exact signs to
// begin with.
#include "core/gather.h"
#include "core/products.h"
#include "surface/point.h"

// The transform that turns a ray into the z axis: axes permuted cyclically, so that the direction's largest component
// becomes z, and sheared.
typedef struct {
    mask x_is_last, y_is_last;
    real shear_x, shear_y, shear_z, last;
} surface_mesh_shear;

static inline vector surface_mesh_turn(const surface_mesh_shear *shear, vector v) {
    return vector_of(pick(pick(v.x, v.z, shear->y_is_last), v.y, shear->x_is_last),
                     pick(pick(v.y, v.x, shear->y_is_last), v.z, shear->x_is_last),
                     pick(pick(v.z, v.y, shear->y_is_last), v.x, shear->x_is_last));
}

static inline surface_mesh_shear surface_mesh_prepare(vector direction) {
    real x = fabs(direction.x), y = fabs(direction.y), z = fabs(direction.z);
    surface_mesh_shear shear;
    shear.x_is_last = test(x >= y) & test(x >= z);
    shear.y_is_last = ~shear.x_is_last & test(y >= z);
    vector d = surface_mesh_turn(&shear, direction);
    shear.shear_x = d.x / d.z;
    shear.shear_y = d.y / d.z;
    shear.shear_z = 1.f / d.z;
    shear.last = d.z;
    return shear;
}

static inline mask surface_mesh_intersect(__global const float *corners, integer at, const surface_mesh_shear *shear,
                                          vector origin, real *t, real *u, real *v) {
    vector p = vector_gather(corners, at), q = vector_gather(corners, at + 3), r = vector_gather(corners, at + 6);
    vector to = vector_along(p, (real)-1.f, origin);
    vector a = surface_mesh_turn(shear, to);
    vector b = surface_mesh_turn(shear, vector_along(q, (real)-1.f, origin));
    vector c = surface_mesh_turn(shear, vector_along(r, (real)-1.f, origin));
    real ax = a.x - shear->shear_x * a.z, ay = a.y - shear->shear_y * a.z;
    real bx = b.x - shear->shear_x * b.z, by = b.y - shear->shear_y * b.z;
    real cx = c.x - shear->shear_x * c.z, cy = c.y - shear->shear_y * c.z;
    real over_a = difference_of_products(bx, cy, by, cx);
    real over_b = difference_of_products(cx, ay, cy, ax);
    real over_c = difference_of_products(ax, by, ay, bx);
    mask above = test(over_a >= 0.f) & test(over_b >= 0.f) & test(over_c >= 0.f);
    mask below = test(over_a <= 0.f) & test(over_b <= 0.f) & test(over_c <= 0.f);
    real area = over_a + over_b + over_c;
    mask hit = (above | below) & test(area != 0.f);
    if (some(hit)) {
        real inverse = 1.f / area;
        // Where the plane is known to be ahead a negative distance is rounding.
        *t = larger((over_a * a.z + over_b * b.z + over_c * c.z) * shear->shear_z * inverse, (real)1e-30f);
        *u = over_b * inverse;
        *v = over_c * inverse;
        vector n = vector_cross(vector_along(q, (real)-1.f, p), vector_along(r, (real)-1.f, p));
        hit &= surface_is_ahead(n, to, area * shear->last);
    }
    return hit;
}

static inline void surface_mesh_locate(__global const float *corners, integer at, real u, real v, surface_point *point) {
    vector p = vector_gather(corners, at), q = vector_gather(corners, at + 3), r = vector_gather(corners, at + 6);
    real w = 1.f - u - v;
    vector n = vector_normalize(vector_cross(vector_along(q, (real)-1.f, p), vector_along(r, (real)-1.f, p)));
    point->position = vector_of(w * p.x + u * q.x + v * r.x, w * p.y + u * q.y + v * r.y, w * p.z + u * q.z + v * r.z);
    point->geometric = n;
    point->error = surface_error(n, vector_of(w * fabs(p.x) + u * fabs(q.x) + v * fabs(r.x),
                                              w * fabs(p.y) + u * fabs(q.y) + v * fabs(r.y),
                                              w * fabs(p.z) + u * fabs(q.z) + v * fabs(r.z)));
}

// The normal between the corners' normals, on the geometric normal's side; faces without have zeros.
static inline vector surface_mesh_shading(__global const float *normals, integer at, real u, real v, vector geometric) {
    vector p = vector_gather(normals, at), q = vector_gather(normals, at + 3), r = vector_gather(normals, at + 6);
    real w = 1.f - u - v;
    vector n = vector_of(w * p.x + u * q.x + v * r.x, w * p.y + u * q.y + v * r.y, w * p.z + u * q.z + v * r.z);
    real scale = copysign(1.f / sqrt(larger(vector_dot(n, n), (real)1e-6f)), vector_dot(n, geometric));
    n = vector_of(n.x * scale, n.y * scale, n.z * scale);
    return vector_pick(geometric, n, test(vector_dot(n, n) > 0.5f));
}

// Uniform in area: Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
static inline void surface_mesh_emit(__global const float *corners, integer at, real u, real v, surface_point *point) {
    mask upper = test(v > u);
    real x = pick(u - 0.5f * v, 0.5f * u, upper), y = pick(0.5f * v, v - 0.5f * u, upper);
    surface_mesh_locate(corners, at, x, y, point);
}
