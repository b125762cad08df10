// An environment from a picture of all directions: longitude across with -z in the middle, latitude down with +y at the
// top. Radiance is bilinear between the middles of texels, all around in longitude, and held from there to the poles.
// A texel is chosen by its luminance × sin θ, row before column, then a place around it by a tent: a sum of tents is a
// bilinear interpolation, so the density is that of what texels weigh. It is above 0 wherever the radiance is, and a
// sample's weight hardly varies. The cumulative weights count the 2^24 steps of a uniform: probabilities are exact.
#include "core/angle.h"
#include "core/light_sample.h"
#include "core/sincos.h"
#include "core/vector.h"

// The four texels around a place in the picture, and how far it lies from the upper left one to the lower right one.
typedef struct { integer above, below, left, right; real down, across; } light_image_place;

static inline light_image_place light_image_around(__constant const struct light_image *light, real x, real y) {
    // Texel i has its middle at i + 1/2; raised by one, so that truncation rounds down.
    light_image_place at;
    integer i = to_integer(x + 0.5f), j = to_integer(y + 0.5f);
    at.across = x + 0.5f - to_real(i);
    at.down = y + 0.5f - to_real(j);
    at.left = pick(i - 1, (integer)(light->width - 1), test(i <= 0));
    at.right = pick(i, (integer)0, test(i >= light->width));
    at.above = clamp_index(j - 1, light->height);
    at.below = clamp_index(j, light->height);
    return at;
}

static inline light_image_place light_image_towards(__constant const struct light_image *light, vector direction) {
    vector d = affine_direction(&light->to_local, direction);
    real longitude = angle_of(d.x, -d.z), theta = angle_of(sqrt(d.x * d.x + d.z * d.z), d.y);
    return light_image_around(light, (0.5f + longitude * 0.159154943f) * (number)light->width,
                              theta * 0.318309886f * (number)light->height);
}

static inline spectrum light_image_row(__constant const struct light_image *light, __global const float *texels, integer row,
                                       const light_image_place *at) {
    integer left = light->texels + (row * light->width + at->left) * light->stride;
    integer right = light->texels + (row * light->width + at->right) * light->stride;
    spectrum s;
    for (int c = 0; c < CHANNELS; ++c) {
        int channel = light->stride > 1 ? c : 0;
        spectrum_channel(s, c) = (1.f - at->across) * gather(float, texels, left + channel)
                               + at->across * gather(float, texels, right + channel);
    }
    return s;
}

static inline spectrum light_image_lookup(__constant const struct light_image *light, __global const float *texels,
                                          const light_image_place *at) {
    spectrum above = spectrum_scale(light_image_row(light, texels, at->above, at), 1.f - at->down);
    spectrum below = spectrum_scale(light_image_row(light, texels, at->below, at), at->down);
    return spectrum_multiply(spectrum_add(above, below), spectrum_uniform(light->scale));
}

// What entry i of a table of cumulative weights adds to it, of 2^24.
static inline real light_image_share(__global const uint *cumulative, integer i) {
    word next = gather(uint, cumulative, i + 1), here = gather(uint, cumulative, i);
    return to_real(word_as_integer(next - here));
}

static inline real light_image_row_share(__constant const struct light_image *light, __global const uint *rows,
                                         __global const uint *columns, integer row, const light_image_place *at) {
    integer first = light->columns + row * (light->width + 1);
    real left = light_image_share(columns, first + at->left), right = light_image_share(columns, first + at->right);
    return light_image_share(rows, light->rows + row) * ((1.f - at->across) * left + at->across * right);
}

// The density per solid angle, times sin θ.
static inline real light_image_density(__constant const struct light_image *light, __global const uint *rows,
                                       __global const uint *columns, const light_image_place *at) {
    return light->density * ((1.f - at->down) * light_image_row_share(light, rows, columns, at->above, at)
                             + at->down * light_image_row_share(light, rows, columns, at->below, at));
}

static inline spectrum light_image_radiance(__constant const struct light_image *light, __global const float *texels,
                                            __global const uint *rows, __global const uint *columns, vector direction) {
    light_image_place at = light_image_towards(light, direction);
    return light_image_lookup(light, texels, &at);
}

static inline real light_image_pdf(__constant const struct light_image *light, __global const float *texels,
                                   __global const uint *rows, __global const uint *columns, vector direction) {
    light_image_place at = light_image_towards(light, direction);
    vector d = affine_direction(&light->to_local, direction);
    return light_image_density(light, rows, columns, &at) / larger(sqrt(d.x * d.x + d.z * d.z), (real)1e-7f);
}

// The last entry that is no greater than step k: one with a share, for k lies below the next.
static inline integer light_image_find(__global const uint *cumulative, integer first, int count, word k) {
    int stride = 1;
    while (stride < count) stride <<= 1;
    integer i = (integer)0;
    for (stride >>= 1; stride > 0; stride >>= 1) {
        integer next = i + stride;
        mask there = test(next < count);
        i = pick(i, next, there & test(gather(uint, cumulative, first + pick(i, next, there)) <= k));
    }
    return i;
}

// A place around the texel that u finds, by a tent one texel wide to each side.
static inline real light_image_tent(__global const uint *cumulative, integer first, integer i, word k) {
    word here = gather(uint, cumulative, first + i);
    real r = (to_real(word_as_integer(k - here)) + 0.5f) / light_image_share(cumulative, first + i);
    mask before = test(r < 0.5f);
    real side = sqrt(2.f * pick(1.f - r, r, before));
    return to_real(i) + 0.5f + pick(1.f - side, side - 1.f, before);
}

static inline void light_image_sample(__constant const struct light_image *light, __global const float *texels,
                                      __global const uint *rows, __global const uint *columns, vector from, real u, real v,
                                      light_sample *s) {
    word k = to_word(u * 0x1p24f), l = to_word(v * 0x1p24f);
    integer row = light_image_find(rows, (integer)light->rows, light->height, k);
    integer first = light->columns + row * (light->width + 1);
    integer column = light_image_find(columns, first, light->width, l);
    real x = light_image_tent(columns, first, column, l), y = light_image_tent(rows, (integer)light->rows, row, k);
    // Around in longitude; tents over a pole are folded back, which makes up for the rows missing there.
    number width = light->width, height = light->height;
    x = pick(pick(x, x + width, test(x < 0.f)), x - width, test(x >= width));
    y = fabs(y);
    y = pick(y, 2.f * height - y, test(y > height));

    real sine, cosine, sin_theta, cos_theta;
    sincos_turns(x / width, &sine, &cosine);
    sincos_turns(0.5f * y / height, &sin_theta, &cos_theta);
    sin_theta = larger(sin_theta, (real)1e-7f);
    s->towards = vector_normalize(
        affine_direction(&light->to_world, vector_of(-sin_theta * sine, cos_theta, sin_theta * cosine)));
    light_image_place at = light_image_around(light, x, y);
    s->distance = (real)1e30f;
    s->pdf = light_image_density(light, rows, columns, &at) / sin_theta;
    // Rounding may put a place where its own tent ends and nothing else begins: no density, and no radiance either.
    s->weight = spectrum_scale(light_image_lookup(light, texels, &at), 1.f / larger(s->pdf, (real)1e-30f));
}
