// A grid of numbers or colours as a medium reads it: its density, albedo, emission or temperature. One unit per voxel, voxel
// i sampled at i + 1/2, clamped at the border. Voxels lie in bricks of 4³, so that neighbours in space are neighbours in
// memory, and a run of bricks that a device would not take in one piece is cut into chunks (compose.py).
#include "core/rng.h"
#include "core/vector.h"

typedef struct { integer brick, voxel; } field_place;
// The eight voxels around a point: their indices along each axis, and the weight of either.
typedef struct { integer i[2], j[2], k[2]; real x[2], y[2], z[2]; } field_cell;

static inline field_place field_at(__constant const struct volume_field *field, integer i, integer j, integer k) {
    field_place at = {((k >> 2) * field->bricks_y + (j >> 2)) * field->bricks_x + (i >> 2),
                      ((k & 3) << 4) | ((j & 3) << 2) | (i & 3)};
    return at;
}

// A voxel on either side of x, with its linear weight; 21 bits of jitter.
static inline integer field_voxel(real x, word jitter, int size) {
    // Positive, so that truncation rounds down.
    real raised = x + 0.5f + to_real(word_as_integer(jitter)) * 0x1p-21f;
    return clamp_index(to_integer(raised) - 1, size);
}

// One tap: the voxel is picked with its trilinear weight. Unbiased in whatever is linear in the value.
static inline field_place field_trilinear(__constant const struct volume_field *field, vector p, words w) {
    return field_at(field, field_voxel(p.x, w.y >> 11u, field->width), field_voxel(p.y, w.z >> 11u, field->height),
                    field_voxel(p.z, ((w.y & 2047u) << 10u) | (w.z & 1023u), field->depth));
}

static inline field_place field_nearest(__constant const struct volume_field *field, vector p) {
    return field_at(field, clamp_index(to_integer(p.x), field->width), clamp_index(to_integer(p.y), field->height),
                    clamp_index(to_integer(p.z), field->depth));
}

static inline void field_cell_axis(real x, int size, integer index[2], real weight[2]) {
    integer raised = to_integer(x + 0.5f);
    weight[1] = x + 0.5f - to_real(raised);
    weight[0] = 1.f - weight[1];
    index[0] = clamp_index(raised - 1, size);
    index[1] = clamp_index(raised, size);
}

static inline field_cell field_cell_of(__constant const struct volume_field *field, vector p) {
    field_cell cell;
    field_cell_axis(p.x, field->width, cell.i, cell.x);
    field_cell_axis(p.y, field->height, cell.j, cell.y);
    field_cell_axis(p.z, field->depth, cell.k, cell.z);
    return cell;
}

// The weights of q among the voxels around p, between which it lies to rounding.
static inline field_cell field_cell_at(const field_cell *around, vector p, vector q) {
    field_cell cell = *around;
    cell.x[1] += q.x - p.x;
    cell.y[1] += q.y - p.y;
    cell.z[1] += q.z - p.z;
    cell.x[0] = 1.f - cell.x[1];
    cell.y[0] = 1.f - cell.y[1];
    cell.z[0] = 1.f - cell.z[1];
    return cell;
}

static inline field_place field_corner(__constant const struct volume_field *field, const field_cell *cell, int corner) {
    return field_at(field, cell->i[corner & 1], cell->j[(corner >> 1) & 1], cell->k[corner >> 2]);
}

static inline real field_weight(const field_cell *cell, int corner) {
    return cell->x[corner & 1] * cell->y[(corner >> 1) & 1] * cell->z[corner >> 2];
}

static inline mask field_holds(__constant const struct volume_field *field, vector p) {
    return test(p.x >= 0.f) & test(p.x <= (float)field->width) & test(p.y >= 0.f) & test(p.y <= (float)field->height)
         & test(p.z >= 0.f) & test(p.z <= (float)field->depth);
}
