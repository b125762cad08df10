// Any media: what lean programs spell out for each (volume/text.py, integrator/full/media.py) as loops over all of them, by
// the same functions of kinds. Fields are by three a medium: density, albedo, and emission or temperature.
#include "core/box.h"
#include "volume/field.h"

#define DENSITY(i) (3 * (i))
#define ALBEDO_OF(i) (3 * (i) + 1)
#define EMISSION_OF(i) (3 * (i) + 2)

// What is stored of a voxel.
static inline spectrum field_fetch(const struct world *world, int f, field_place at) {
    __constant const struct stored_field *stored = &world->scene->stored[f];
    const int storage = stored->storage, channels = stored->channels;
    const integer chunk = (integer)(int)stored->chunk + (at.brick >> (int)stored->shift);
    const integer voxel = ((at.brick & (integer)(int)stored->bricks) << 6) | at.voxel;
    const integer index = (integer)(int)stored->first + channels * voxel;
    if (channels == 1) return spectrum_grey(field_number(world, storage, chunk, index));
    return spectrum_of(field_number(world, storage, chunk, index), field_number(world, storage, chunk, index + 1),
                       field_number(world, storage, chunk, index + 2));
}

// A lookup in the field's own space, of one voxel, and of all eight.
static inline spectrum field_tap(const struct world *world, int f, vector p, words w) {
    __constant const struct volume_field *field = &world->scene->fields[f];
    if (world->scene->stored[f].nearest) return field_fetch(world, f, field_nearest(field, p));
    return field_fetch(world, f, field_trilinear(field, p, w));
}
static inline spectrum field_exact(const struct world *world, int f, vector p) {
    __constant const struct volume_field *field = &world->scene->fields[f];
    if (world->scene->stored[f].nearest) return field_fetch(world, f, field_nearest(field, p));
    field_cell cell = field_cell_of(field, p);
    spectrum sum = spectrum_grey((real)0.f);
    for (int corner = 0; corner < 8; ++corner) {
        spectrum value = field_fetch(world, f, field_corner(field, &cell, corner));
        sum = spectrum_add(sum, spectrum_scale(value, field_weight(&cell, corner)));
    }
    return sum;
}
static inline spectrum field_within(const struct world *world, int f, vector p, spectrum value) {
    mask holds = field_holds(&world->scene->fields[f], p);
    return spectrum_pick(spectrum_grey((real)0.f), value, holds);
}

// Of medium i at a point of its local space; one that is no grid is the same everywhere.
static inline coefficient medium_sigma_t(const struct world *world, int i, vector p, words w) {
    spectrum density = field_within(world, DENSITY(i), p, field_tap(world, DENSITY(i), p, w));
    return coefficient_multiply(spectrum_uniform(world->scene->media[i].sigma_t), density);
}
static inline coefficient medium_sigma_t_exact(const struct world *world, int i, vector p) {
    coefficient sigma_t = spectrum_uniform(world->scene->media[i].sigma_t);
    if (!world->scene->media[i].grid) return sigma_t;
    return coefficient_multiply(sigma_t, field_within(world, DENSITY(i), p, field_exact(world, DENSITY(i), p)));
}
static inline spectrum medium_albedo(const struct world *world, int i, vector p, words w) {
    const int f = ALBEDO_OF(i);
    spectrum albedo = spectrum_uniform(world->scene->media[i].albedo);
    if (!world->scene->stored[f].channels) return albedo;
    vector q = affine_point(&world->scene->fields[f].from_local, p);
    return spectrum_multiply(albedo, field_within(world, f, q, field_tap(world, f, q, w)));
}
static inline spectrum medium_albedo_exact(const struct world *world, int i, vector p) {
    const int f = ALBEDO_OF(i);
    spectrum albedo = spectrum_uniform(world->scene->media[i].albedo);
    if (!world->scene->stored[f].channels) return albedo;
    vector q = affine_point(&world->scene->fields[f].from_local, p);
    return spectrum_multiply(albedo, field_within(world, f, q, field_exact(world, f, q)));
}
static inline spectrum medium_emission(const struct world *world, int i, vector p) {
    __constant const struct medium *medium = &world->scene->media[i];
    const int f = EMISSION_OF(i);
    spectrum value = spectrum_grey((real)0.f), epsilon = value;
    if (world->scene->stored[f].channels) {
        vector q = affine_point(&world->scene->fields[f].from_local, p);
        value = field_within(world, f, q, field_exact(world, f, q));
    }
    if (medium->emission == EMISSION_CONSTANT) epsilon = emission_constant_epsilon(&world->scene->emission_constant[i]);
    if (medium->emission == EMISSION_GRID) epsilon = emission_grid_epsilon(&world->scene->emission_grid[i], value);
    if (medium->emission == EMISSION_BLACKBODY)
        epsilon = emission_blackbody_radiance(&world->scene->emission_blackbody[i], world->emission_tables + medium->table,
                                              spectrum_channel(value, 0));
    if (medium->thermal) {
        spectrum scattered = spectrum_scale(medium_albedo_exact(world, i, p), (real)-1.f);
        spectrum absorbed = spectrum_add(spectrum_grey((real)1.f), scattered);
        epsilon = spectrum_multiply(epsilon, spectrum_multiply(absorbed, medium_sigma_t_exact(world, i, p)));
    }
    return medium->grid ? field_within(world, DENSITY(i), p, epsilon) : epsilon;
}

static inline vector medium_local(const struct world *world, int i, vector x) {
    return affine_point(&world->scene->media[i].to_local, x);
}
