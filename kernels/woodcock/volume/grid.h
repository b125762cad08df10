// Density on a regular grid; local space has one unit per voxel, voxel i sampled at i + 1/2, clamped at the border.
// One-tap stochastic trilinear lookup: the voxel is picked with its trilinear weight, which is unbiased because both
// delta tracking's acceptance and ratio tracking's factor are linear in the density.
// Voxels lie in bricks of 4³, so that neighbours in space are neighbours in memory. Density is relative to the majorant.
#include "core/rng.h"
#include "core/vector.h"

static inline integer volume_grid_voxel(real x, word jitter, int size) {
    // Positive, so that truncation rounds down.
    real raised = x + 0.5f + to_real(word_as_integer(jitter)) * 0x1p-21f;
    return clamp_index(to_integer(raised) - 1, size);
}

static inline real volume_grid_density(__constant const struct volume_grid *volume, __global const density_storage *density,
                                       vector p, words w) {
    integer i = volume_grid_voxel(p.x, w.y >> 11u, volume->width);
    integer j = volume_grid_voxel(p.y, w.z >> 11u, volume->height);
    integer k = volume_grid_voxel(p.z, ((w.y & 2047u) << 10u) | (w.z & 1023u), volume->depth);
    integer brick = ((k >> 2) * volume->bricks_y + (j >> 2)) * volume->bricks_x + (i >> 2);
    integer index = (brick << 6) | ((k & 3) << 4) | ((j & 3) << 2) | (i & 3);
    return density_fetch(density, index) * volume->relative;
}
