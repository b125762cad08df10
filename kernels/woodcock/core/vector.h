// Three-vectors: `vector` holds lanes, `vector3` and `affine` the same number for all lanes, as the scene's record does.
typedef struct { real x, y, z; } vector;
typedef struct { number x, y, z; } vector3;
// Rows of a 3 × 4 matrix, applied to column vectors.
typedef struct { number xx, xy, xz, x0, yx, yy, yz, y0, zx, zy, zz, z0; } affine;

static inline vector vector_of(real x, real y, real z) {
    vector v = {x, y, z};
    return v;
}

static inline vector vector_uniform(vector3 v) { return vector_of((real)v.x, (real)v.y, (real)v.z); }

// a + t b
static inline vector vector_along(vector a, real t, vector b) {
    return vector_of(a.x + t * b.x, a.y + t * b.y, a.z + t * b.z);
}

static inline real vector_dot(vector a, vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

static inline vector vector_normalize(vector a) {
    real s = 1.f / sqrt(vector_dot(a, a));
    return vector_of(a.x * s, a.y * s, a.z * s);
}

static inline vector vector_pick(vector no, vector yes, mask chosen) {
    return vector_of(pick(no.x, yes.x, chosen), pick(no.y, yes.y, chosen), pick(no.z, yes.z, chosen));
}

static inline vector affine_point(__constant const affine *m, vector p) {
    return vector_of(m->xx * p.x + m->xy * p.y + m->xz * p.z + m->x0, m->yx * p.x + m->yy * p.y + m->yz * p.z + m->y0,
                     m->zx * p.x + m->zy * p.y + m->zz * p.z + m->z0);
}

static inline vector affine_direction(__constant const affine *m, vector d) {
    return vector_of(m->xx * d.x + m->xy * d.y + m->xz * d.z, m->yx * d.x + m->yy * d.y + m->yz * d.z,
                     m->zx * d.x + m->zy * d.y + m->zz * d.z);
}
