// The nearest surface along a ray, by a hierarchy of boxes laid out depth first with skip links: a box that is met leads to
// the next one, a box that is missed to its link (Smits, "Efficiency issues for ray tracing", JGT 3(2), 1998). No stack.
// Slabs as in Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013: the far distance is rounded up, so that no box is missed.
#include "surface/point.h"

// A component of zero becomes one that no box notices, so that no product below is NaN.
static inline real surface_inverse(real d) { return 1.f / pick(d, (real)1e-20f, test(fabs(d) < 1e-20f)); }

static inline void surface_slab(real low, real high, real origin, real inverse, real *near, real *far) {
    real a = (low - origin) * inverse, b = (high - origin) * inverse;
    *near = larger(*near, smaller(a, b));
    *far = smaller(*far, larger(a, b));
}

// The nearest hit before `limit`: t = 1e30 where there is none, and in lanes that are not active.
static inline surface_hit surface_intersect(const struct world *world, vector origin, vector direction, real limit, mask active) {
    __global const float *boxes = world->surface_boxes;
    __global const int *links = world->surface_links;
    const vector inverse = vector_of(surface_inverse(direction.x), surface_inverse(direction.y), surface_inverse(direction.z));
    const surface_prepared prepared = surface_prepare(direction);
    const integer end = (integer)links[0];  // the root's link: the number of boxes
    surface_hit hit = {limit, (integer)-1, (real)0.f, (real)0.f};
    integer box = pick(end, (integer)0, active);
    while (some(test(box < end))) {
        mask going = test(box < end);
        integer at = pick((integer)0, box, going);
        real near = (real)0.f, far = hit.t;
        surface_slab(gather(float, boxes, 6 * at), gather(float, boxes, 6 * at + 3), origin.x, inverse.x, &near, &far);
        surface_slab(gather(float, boxes, 6 * at + 1), gather(float, boxes, 6 * at + 4), origin.y, inverse.y, &near, &far);
        surface_slab(gather(float, boxes, 6 * at + 2), gather(float, boxes, 6 * at + 5), origin.z, inverse.z, &near, &far);
        mask met = going & test(near <= far * 1.0000005f);
        // A leaf holds 8 × its first primitive + how many; other boxes -1.
        integer leaf = gather(int, links, 2 * at + 1);
        integer primitive = leaf >> 3, left = pick((integer)0, leaf & 7, met & test(leaf >= 0));
        while (some(test(left > 0))) {
            mask tried = test(left > 0);
            integer tested = pick((integer)0, primitive, tried);
            surface_hit other = {(real)1e30f, tested, (real)0.f, (real)0.f};
            mask closer = surface_test(world, &prepared, tested, origin, direction, tried, &other) & test(other.t < hit.t);
            hit.t = pick(hit.t, other.t, closer);
            hit.primitive = pick(hit.primitive, tested, closer);
            hit.u = pick(hit.u, other.u, closer);
            hit.v = pick(hit.v, other.v, closer);
            primitive += 1;
            left -= 1;
        }
        box = pick(pick(box, gather(int, links, 2 * at), going), box + 1, met);
    }
    hit.t = pick(hit.t, (real)1e30f, test(hit.primitive < 0));
    return hit;
}
