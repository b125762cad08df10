#line 1 "core/lanes_8.h"
// Lane types, eight lanes (AVX).
#define LANES 8
#line 1 "core/lanes_vector.h"
// Lane types over OpenCL vectors; lanes_4.h, lanes_8.h and lanes_16.h set LANES, lane_index and gather.
#define LANES_JOIN_(a, b) a##b
#define LANES_JOIN(a, b) LANES_JOIN_(a, b)
typedef float number;
typedef LANES_JOIN(float, LANES) real;
typedef LANES_JOIN(int, LANES) integer;
typedef LANES_JOIN(uint, LANES) word;
typedef LANES_JOIN(int, LANES) mask;
#define to_real(x) LANES_JOIN(convert_float, LANES)(x)
#define to_integer(x) LANES_JOIN(convert_int, LANES)(x)
#define to_word(x) LANES_JOIN(convert_uint, LANES)(x)
#define word_as_integer(x) LANES_JOIN(as_int, LANES)(x)
#define integer_as_word(x) LANES_JOIN(as_uint, LANES)(x)
#define word_as_real(x) LANES_JOIN(as_float, LANES)(x)
#define real_as_word(x) LANES_JOIN(as_uint, LANES)(x)
#define test(condition) (condition)
// Operators rather than the builtins select, any, fmin and fmax: PoCL may call these as functions, spilling all registers.
#define pick(no, yes, chosen) ((chosen) ? (yes) : (no))
#define lanes_store(x, p) LANES_JOIN(vstore, LANES)(x, 0, p)
#line 4 "core/lanes_8.h"
#define lane_index() ((integer)(0, 1, 2, 3, 4, 5, 6, 7))
#define gather(type, p, i) ((LANES_JOIN(type, LANES))((p)[(i).s0], (p)[(i).s1], (p)[(i).s2], (p)[(i).s3], \
                                                      (p)[(i).s4], (p)[(i).s5], (p)[(i).s6], (p)[(i).s7]))

static inline int some(mask m) {
    int4 a = m.lo | m.hi;
    int2 b = a.lo | a.hi;
    return b.x | b.y;
}
#line 1 "core/lanes_math.h"
// Minima and maxima by operators (see lanes_vector.h). `b` where either is NaN.
static inline real smaller(real a, real b) { return pick(b, a, test(a < b)); }
static inline real larger(real a, real b) { return pick(b, a, test(a > b)); }
static inline integer clamp_index(integer i, int size) {
    integer last = (integer)(size - 1);
    i = pick(i, (integer)0, test(i < 0));
    return pick(i, last, test(i > last));
}
#line 14 "core/lanes_8.h"
#line 1 "core/precision_float.h"
// What depends on the precision of lanes: floats. EPSILON is the largest relative error of one rounding;
// steps are no shorter than SMALLEST_STEP times where they begin.
#define EPSILON 0x1p-24f
#define SMALLEST_STEP 0x1p-16f

static inline void store_pair(real high, real low, __global float *film, size_t plane) {
    lanes_store(high, film);
    lanes_store(low, film + plane);
}
#define store_count(n, p) lanes_store(integer_as_word(n), p)
#define store_bits(x, p) lanes_store(real_as_word(x), p)
#line 1 "core/rng.h"
// Random numbers are addressed, not drawn in order: (seed, pixel, sample, dimension) -> four words, a 128-bit address.
// So any range of samples can be rendered anywhere, in any order, again after a crash, and means the same.
typedef struct { word x, y, z, w; } words;

// pcg4d: Jarzynski & Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020.
static inline words pcg4d(words v) {
    v.x = v.x * 1664525u + 1013904223u;
    v.y = v.y * 1664525u + 1013904223u;
    v.z = v.z * 1664525u + 1013904223u;
    v.w = v.w * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v.x ^= v.x >> 16u;
    v.y ^= v.y >> 16u;
    v.z ^= v.z >> 16u;
    v.w ^= v.w >> 16u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// The address of a path; `dimension` counts the words taken along it, four at a time.
typedef struct { word pixel, sample, dimension; uint seed; } rng_address;

// The hash's low bits alone are biased (roulette on bit 0: by 0.8 %), so low halves are mixed with high ones.
static inline words rng_words(const rng_address *at, word dimension) {
    words v = {at->pixel, at->sample, (word)at->seed, dimension};
    v = pcg4d(v);
    v.x ^= v.x >> 16u;
    v.y ^= v.y >> 16u;
    v.z ^= v.z >> 16u;
    v.w ^= v.w >> 16u;
    return v;
}

// The next four words; the address moves on in the lanes that take them, so that no path depends on its neighbours.
static inline words rng_next(rng_address *at, mask taken) {
    words v = rng_words(at, at->dimension);
    at->dimension -= integer_as_word(taken);
    return v;
}

// Uniform in [0, 1), 24 bits.
static inline real unit(word w) { return to_real(word_as_integer(w >> 8u)) * 0x1p-24f; }

// Uniform in (0, 1], 31 bits, of which a real keeps 24 significant ones: small values are as precise as large ones.
static inline real unit_fine(word w) { return (to_real(word_as_integer(w >> 1u)) + 0.5f) * 0x1p-31f; }

// Below 2^-13 the bits go on with those of a word of its own, down to 2^-64.
static inline mask unit_is_small(word w) { return test((w >> 19u) == 0u); }
static inline real unit_small(word w, word deep) { return (to_real(word_as_integer(w >> 1u)) + unit_fine(deep)) * 0x1p-31f; }

// A free flight, in mean free paths: the exponential law to 44 of them, and as precise for short ones. `u` is a uniform
// of its own, for the choice at the flight's end; it is as precise for tiny probabilities.
static inline real rng_flight(const rng_address *at, words w, real *u) {
    real depth = -log(unit_fine(w.x));
    *u = unit_fine(w.w);
    mask long_or_short = unit_is_small(w.x + 0x40000u), choice = unit_is_small(w.w);
    if (some(long_or_short | choice)) {
        // No step has this address: dimensions stay below 2^31. (One high bit would not do: pcg4d hardly spreads it.)
        words deep = rng_words(at, ~at->dimension);
        real high = unit_small(w.x, deep.x), low = unit_small(~w.x, deep.x);
        // -log(1 - low), to low^2 / 3.
        real tail = pick(low + 0.5f * low * low, -log(high), test((w.x >> 31u) == 0u));
        depth = pick(depth, tail, long_or_short);
        *u = pick(*u, unit_small(w.w, deep.w), choice);
    }
    return depth;
}
#line 1 "core/vector.h"
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
#line 1 "core/spectrum_1.h"
// Spectra, one channel: a grey scene. `spectrum` holds lanes, `colour` the same for all lanes.
#define CHANNELS 1
typedef real spectrum;
typedef number colour;
#define spectrum_channel(s, c) (s)

static inline spectrum spectrum_uniform(colour c) { return (real)c; }
static inline spectrum spectrum_grey(real v) { return v; }
static inline spectrum spectrum_add(spectrum a, spectrum b) { return a + b; }
static inline spectrum spectrum_multiply(spectrum a, spectrum b) { return a * b; }
static inline spectrum spectrum_scale(spectrum a, real s) { return a * s; }
static inline spectrum spectrum_pick(spectrum no, spectrum yes, mask chosen) { return pick(no, yes, chosen); }
static inline real spectrum_max(spectrum a) { return a; }
#line 1 "generated"
struct film { int width; int height; uint seed; };
struct camera_perspective { vector3 corner; vector3 right; vector3 down; vector3 origin; };
struct volume_constant { affine to_local; vector3 size; colour albedo; };
struct majorant_global { float mean_free_path; };
struct phase_henyey_greenstein { float g; float gap; };
struct light_directional { vector3 towards; colour irradiance; };
struct guide { float g; float gap; float share; float surface_share; float settle; };
struct scene { struct film film; struct camera_perspective camera; struct volume_constant volume; struct majorant_global majorant; struct phase_henyey_greenstein phase; struct light_directional light_0; struct guide guide; };
#line 1 "camera/perspective.h"
// A pinhole. Rays are anchored on a plane through the scene's middle, computed in float64 on the host, so that a camera
// a million object sizes away loses no precision; `start` is where the pinhole lies on the ray, relative to the anchor.


static inline void camera_perspective_ray(__constant const struct camera_perspective *camera, real u, real v,
                                          vector *anchor, vector *direction, real *start) {
    vector corner = vector_uniform(camera->corner), right = vector_uniform(camera->right), down = vector_uniform(camera->down);
    *anchor = vector_along(vector_along(corner, u, right), v, down);
    vector away = vector_along(*anchor, (real)-1.f, vector_uniform(camera->origin));
    real distance = sqrt(vector_dot(away, away));
    *direction = vector_of(away.x / distance, away.y / distance, away.z / distance);
    *start = -distance;
}
#line 1 "volume/constant.h"
// A homogeneous medium in a box; local space is the unit cube. Density is relative to the majorant.



static inline real volume_constant_density(__constant const struct volume_constant *volume, vector p, words w) {
    return (real)1.f;
}
#line 1 "tracking/analytic.h"
// Free flight in a homogeneous medium: the majorant is σ_t, and collisions are real.
static inline mask free_flight_analytic_collides(real density, real u) { return (mask)-1; }
#line 1 "tracking/exact.h"
// Transmittance of a homogeneous medium, exp(-σ_t s): the walk is over in one step.
static inline mask transmittance_exact_step(real *transmittance, real density, real length, real mean_free_path, mask escape, real u) {
    *transmittance = exp(-length / mean_free_path);
    return (mask)-1;
}
#line 1 "majorant/global.h"
// One bound on σ_t for the whole volume.
static inline real majorant_global_mean_free_path(__constant const struct majorant_global *majorant) {
    return (real)majorant->mean_free_path;
}
#line 1 "phase/henyey_greenstein.h"
// Henyey & Greenstein, "Diffuse radiation in the galaxy", ApJ 93, 1941.
#line 1 "phase/lobe_henyey_greenstein.h"
// A lobe in the versine from its peak's axis, m = 1 ∓ cos θ for g ≷ 0: the textbook forms divide by g and cancel near the
// peak, these do neither. gap = 1 - |g|, from the host.
#line 1 "core/warp.h"
#line 1 "core/frame.h"
// An orthonormal frame around a unit vector without branches: Duff et al., "Building an Orthonormal Basis, Revisited",
// JCGT 6(1), 2017. Returns x s + y t + z n.


static inline vector frame_to_world(vector n, real x, real y, real z) {
    real sign = copysign((real)1.f, n.z), a = -1.f / (sign + n.z), b = n.x * n.y * a;
    vector s = vector_of(1.f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    vector t = vector_of(b, sign + n.y * n.y * a, -n.y);
    return vector_of(x * s.x + y * t.x + z * n.x, x * s.y + y * t.y + z * n.y, x * s.z + y * t.z + z * n.z);
}
#line 2 "core/warp.h"
#line 1 "core/sincos.h"
// Sine and cosine of 2π u, 0 <= u <= 1: reduced to an eighth of a turn, then minimax polynomials (Cephes sinf, cosf).
static inline void sincos_turns(real u, real *sine, real *cosine) {
    real turns = u * 4.f, rounded = turns + 0.5f;
    integer k = to_integer(rounded);  // positive, so that truncation rounds down
    real r = (turns - to_real(k)) * 1.57079633f, r2 = r * r;
    real s = r * (1.f + r2 * (-0.166666546f + r2 * (8.3321608736e-3f - 1.9515295891e-4f * r2)));
    real c = 1.f - 0.5f * r2 + r2 * r2 * (4.166664568e-2f + r2 * (-1.388731625e-3f + 2.443315712e-5f * r2));
    mask odd = test((k & 1) != 0);
    *sine = pick(pick(s, c, odd), -pick(s, c, odd), test((k & 2) != 0));
    *cosine = pick(pick(c, s, odd), -pick(c, s, odd), test(((k + 1) & 2) != 0));
}
#line 3 "core/warp.h"

// The unit vector at an angle to `axis` given by its versine, 1 - cos θ, which keeps the precision that cos θ loses
// near 1, turned by `azimuth` full turns. Normalised, so that long paths do not drift.
static inline vector warp_around(vector axis, real versine, real azimuth) {
    real sine, cosine, radius = sqrt(versine * (2.f - versine));
    sincos_turns(azimuth, &sine, &cosine);
    return vector_normalize(frame_to_world(axis, radius * cosine, radius * sine, 1.f - versine));
}
#line 4 "phase/lobe_henyey_greenstein.h"

// p = (1 - g²) / 4π (1 + g² - 2 g cos θ)^(3/2), with 1 + g² - 2 g cos θ = gap² + 2 |g| m and m = |in ∓ out|² / 2.
static inline real lobe_henyey_greenstein_at(number g, number gap, vector in, vector out) {
    vector chord = vector_along(in, (real)-copysign((number)1.f, g), out);
    real squared = gap * gap + fabs(g) * vector_dot(chord, chord);
    return 0.0795774715f * gap * (1.f + fabs(g)) / (squared * sqrt(squared));
}

// The textbook inverse of the distribution function, solved for m = 2 gap² (1 - u) (1 + |g| u) / (gap + 2 |g| u)²; rest = 1 - u.
static inline vector lobe_henyey_greenstein_around(real g, real gap, vector in, real u, real rest, real v) {
    real side = copysign((real)1.f, g), size = fabs(g), ratio = gap / (gap + 2.f * size * u);
    real m = 2.f * ratio * ratio * rest * (1.f + size * u);
    return warp_around(vector_of(in.x * side, in.y * side, in.z * side), smaller(m, (real)2.f), v);
}
#line 3 "phase/henyey_greenstein.h"

static inline real phase_henyey_greenstein_eval(__constant const struct phase_henyey_greenstein *phase, vector in, vector out) {
    return lobe_henyey_greenstein_at(phase->g, phase->gap, in, out);
}

static inline vector phase_henyey_greenstein_sample(__constant const struct phase_henyey_greenstein *phase, vector in,
                                                    real u, real v) {
    return lobe_henyey_greenstein_around((real)phase->g, (real)phase->gap, in, u, 1.f - u, v);
}

static inline real phase_henyey_greenstein_pdf(__constant const struct phase_henyey_greenstein *phase, vector in, vector out) {
    return phase_henyey_greenstein_eval(phase, in, out);
}
#line 1 "light/directional.h"
// Parallel light from infinitely far away. No sampled direction ever hits it, so next-event estimation is its only
// estimator; its density is a delta, so the weight is the irradiance itself.


static inline vector light_directional_sample(__constant const struct light_directional *light, spectrum *weight) {
    *weight = spectrum_uniform(light->irradiance);
    return vector_uniform(light->towards);
}
#line 1 "generated"
struct world { __constant const struct scene *scene; };
#line 1 "generated"
static inline void camera_ray(const struct world *world, real u, real v, vector *anchor, vector *direction,
                              real *start) {
    camera_perspective_ray(&world->scene->camera, u, v, anchor, direction, start);
}
static inline __constant const affine *volume_to_local(const struct world *world) {
    return &world->scene->volume.to_local;
}
static inline vector3 volume_size(const struct world *world) { return world->scene->volume.size; }
static inline spectrum volume_albedo(const struct world *world) {
    return spectrum_uniform(world->scene->volume.albedo);
}
static inline real volume_density(const struct world *world, vector p, words w) {
    return volume_constant_density(&world->scene->volume, p, w);
}
static inline real majorant_mean_free_path(const struct world *world) {
    return majorant_global_mean_free_path(&world->scene->majorant);
}
static inline mask free_flight_collides(real density, real u) { return free_flight_analytic_collides(density, u); }
static inline vector phase_sample(const struct world *world, vector in, real u, real v) {
    return phase_henyey_greenstein_sample(&world->scene->phase, in, u, v);
}
static inline spectrum light_radiance(const struct world *world, vector direction) { return spectrum_grey((real)0.f); }
static inline real phase_eval(const struct world *world, vector in, vector out) {
    return phase_henyey_greenstein_eval(&world->scene->phase, in, out);
}
static inline mask transmittance_step(const struct world *world, real *value, real density, real length, mask escape,
                                      real u) {
    return transmittance_exact_step(value, density, length, majorant_mean_free_path(world), escape, u);
}
static inline vector light_sample(const struct world *world, real u, spectrum *weight) {
    vector towards = light_directional_sample(&world->scene->light_0, weight);
    return towards;
}
#line 1 "integrator/flight_global.h"
// Flights of the small loop under one bound on σ_t.
#line 1 "core/box.h"
// A volume's bounds in its local space: from the origin to `size`.


static inline real box_face(real o, real d, number size) {
    return pick((pick((real)0.f, (real)size, test(d > 0.f)) - o) / d, (real)1e30f, test(d == 0.f));
}

// Distance from a point inside to the face ahead; 0 or more.
static inline real box_exit(vector3 size, vector o, vector d) {
    real t = smaller(box_face(o.x, d.x, size.x), smaller(box_face(o.y, d.y, size.y), box_face(o.z, d.z, size.z)));
    return larger(t, (real)0.f);
}

static inline void box_slab(real o, real d, number size, real *near, real *far) {
    real a = -o / d, b = ((real)size - o) / d;
    mask parallel = test(d == 0.f), outside = parallel & (test(o < 0.f) | test(o > (real)size));
    *near = larger(*near, pick(pick(smaller(a, b), (real)-1e30f, parallel), (real)1e30f, outside));
    *far = smaller(*far, pick(larger(a, b), (real)1e30f, parallel));
}

// Where a ray from outside or inside runs through the box: near < far if it does at all.
static inline void box_clip(vector3 size, vector o, vector d, real *near, real *far) {
    box_slab(o.x, d.x, size.x, near, far);
    box_slab(o.y, d.y, size.y, near, far);
    box_slab(o.z, d.z, size.z, near, far);
}
#line 3 "integrator/flight_global.h"
#line 1 "core/path.h"
// The state of a lane's path. Positions lie in the volume's local space and are kept relative to the last collision:
// `origin` + `t` × `along`, so that small steps are never added to a large number. `t` is a length in the scene.



typedef struct {
    rng_address random;
    vector origin, along;  // last collision or entry; direction of the flight (or shadow walk) in local space
    vector direction;      // direction of travel in the scene
    real t, t_low, t_exit; // along the flight, and what rounding left of it; where it leaves the volume
    spectrum throughput, radiance;
    integer order;         // scatterings so far
} path;

// Adds a step to t, compensated (Kahan 1965): t += step stalls for ever once the step is below half an ulp of t.
static inline void path_advance(path *p, real step) {
    real y = step + p->t_low, t = p->t + y;
    p->t_low = y - (t - p->t);
    p->t = t;
}
#line 4 "integrator/flight_global.h"
typedef struct { int unused; } flight;

static inline real flight_exit(const struct world *world, const path *p) {
    return box_exit(volume_size(world), p->origin, p->along);
}
static inline void flight_start(flight *f, path *p, const struct world *world, mask chosen) {
    p->t = pick(p->t, (real)0.f, chosen);
    p->t_low = pick(p->t_low, (real)0.f, chosen);
}
static inline mask flight_step(flight *f, path *p, const struct world *world, real depth) {
    path_advance(p, depth * majorant_mean_free_path(world));
    return test(p->t >= p->t_exit);
}
static inline real flight_density(const flight *f, const struct world *world, vector at, words w) {
    return volume_density(world, at, w);
}
#line 1 "integrator/next_event.h"
// Next-event estimation as a second mode of a lane: from a collision the lane walks towards a light, by the steps of a
// free flight, and scatters on arrival. The vertex is the walk's origin: nothing needs restoring.
#line 1 "core/roulette.h"
// Russian roulette: with which chance what goes on, and weighs so much more.

// Below a fifth of the weight by odds that lift it there, even ones at worst.
static inline real roulette_chance(real weight) {
    return pick((real)0.f, smaller(larger(weight * 5.f, (real)0.5f), (real)1.f), test(weight != 0.f));
}

// A walk to a light is as long whatever it brings: of what scatters into its direction, over what even scattering would; an
// eighth at least, as nothing else may bring any.
static inline real roulette_walk(real scattered) { return smaller(larger(12.5663706f * scattered, (real)0.125f), (real)1.f); }
#line 4 "integrator/next_event.h"

typedef struct {
    mask walking;
    real transmittance;
    vector towards;
    spectrum weight; // what arrives if nothing is lost
} next_event;

static inline mask next_event_walking(const next_event *event) { return event->walking; }

// One step of the walks; returns lanes that have arrived or lost all weight, and scatter now.
static inline mask next_event_step(next_event *event, const struct world *world, path *p, real density, mask escape, real u) {
    real transmittance = event->transmittance;
    mask over = transmittance_step(world, &transmittance, density, p->t_exit, escape, u) & event->walking;
    event->transmittance = pick(event->transmittance, transmittance, event->walking);
    if (some(over)) {
        spectrum light = spectrum_scale(event->weight, transmittance);
        p->radiance = spectrum_pick(p->radiance, spectrum_add(p->radiance, light), over);
        event->walking &= ~over;
    }
    return over;
}

// Sends lanes that have collided towards a light; the others scatter at once. `odds`, uniform in (0, 1], decides.
static inline mask next_event_start(next_event *event, const struct world *world, path *p, mask collide, real u, real odds) {
    spectrum weight;
    vector towards = light_sample(world, u, &weight);
    real phase = phase_eval(world, p->direction, towards), chance = roulette_walk(phase);
    mask walk = collide & test(odds <= chance);
    weight = spectrum_scale(spectrum_multiply(weight, p->throughput), phase / chance);
    event->towards = vector_pick(event->towards, towards, walk);
    event->weight = spectrum_pick(event->weight, weight, walk);
    event->transmittance = pick(event->transmittance, (real)1.f, walk);
    event->walking |= walk;
    p->along = vector_pick(p->along, affine_direction(volume_to_local(world), towards), walk);
    return collide & ~walk;
}
#line 1 "integrator/guide.h"
// Directions towards lights that next-event estimation alone finds. What a flight gathers of such a light is proportional to
// the phase function at its end, so that of all directions those matter where the product of two phase functions is large, that
// of the vertex and that of the next one towards the light. A small share of directions is sampled by the second, a
// Henyey-Greenstein lobe around the light, and weighed against the first by the balance heuristic of one sample (Veach & Guibas
// 1995): without them the few paths that come by such a direction are fireflies. A direction of the first alone then weighs
// 1 / (1 - share), which a path of many scatterings multiplies up; so the share falls with their number, and is small where the
// medium is opaque and where lobes are narrow (guide.py).


static inline real guide_share(const struct world *world, integer order) {
    return (real)world->scene->guide.share / ((real)world->scene->guide.settle + to_real(order));
}
static inline real guide_surface_share(const struct world *world, integer order) {
    return (real)world->scene->guide.surface_share / ((real)world->scene->guide.settle + to_real(order));
}
static inline vector guide_sample(const struct world *world, vector axis, real u, real v) {
    return lobe_henyey_greenstein_around((real)world->scene->guide.g, (real)world->scene->guide.gap, axis, u, 1.f - u, v);
}
static inline real guide_pdf(const struct world *world, real share, vector axis, vector to, real phase) {
    real lobe = lobe_henyey_greenstein_at(world->scene->guide.g, world->scene->guide.gap, axis, to);
    return phase + share * (lobe - phase);
}
// Towards a light in the scene, also from where it is.
static inline vector guide_towards(vector place, vector from) {
    vector to = vector_along(place, (real)-1.f, from);
    real inverse = 1.f / sqrt(larger(vector_dot(to, to), (real)1e-24f));
    return vector_of(to.x * inverse, to.y * inverse, to.z * inverse);
}
#line 1 "generated"
static inline vector guide_axis(const struct world *world, integer order) {
    vector axis = vector_uniform(world->scene->light_0.towards);
    return axis;
}
#line 1 "integrator/scatter_guided.h"
// The direction in which a path of the small loop goes on, some of them towards lights.
static inline vector path_scatter(path *p, const struct world *world, words v, mask scatter) {
    vector axis = guide_axis(world, p->order);
    real share = guide_share(world, p->order), u = unit(v.z);
    mask guided = test(u < share);
    // One uniform chooses the lobe and, stretched again, samples it.
    u = pick((u - share) / (1.f - share), u / share, guided);
    vector out = vector_pick(phase_sample(world, p->direction, u, unit(v.w)), guide_sample(world, axis, u, unit(v.w)), guided);
    real phase = phase_eval(world, p->direction, out), weight = phase / guide_pdf(world, share, axis, out, phase);
    p->throughput = spectrum_pick(p->throughput, spectrum_scale(p->throughput, weight), scatter);
    p->order = pick(p->order, p->order + 1, scatter);
    return out;
}
#line 1 "integrator/volumetric_path.cl"
// The volume rendering equation with scattering, L = L0 + K L0 + K² L0 + …, by tracing paths from the camera.
// A lane is one path of its own pixel; one whose path ends starts its pixel's next sample at once.
#line 1 "core/audit.h"
// What a kernel finds amiss in its own work: samples that are no radiance, by what they are, and tentative collisions where σ_t
// exceeded its majorant: how many, the throughput of the paths that they befell, and by which factor at most.


typedef struct {
    integer nan, infinite, negative, unfinished, violations;
    real touched, excess;
} audit;

// Counts values that are no radiance. There are none, as a rule: nothing but the question costs time.
static inline void audit_value(audit *a, real value, mask bad) {
    if (!some(bad)) return;
    mask nan = bad & test(value != value), negative = bad & test(value < 0.f);
    a->nan -= nan;
    a->negative -= negative;
    a->infinite -= bad & ~(nan | negative);
}

// Counts collisions with a σ_t of `excess` majorants.
static inline void audit_majorant(audit *a, real excess, real throughput, mask violated) {
    if (!some(violated)) return;
    a->violations -= violated;
    a->touched += pick((real)0.f, throughput, violated);
    a->excess = pick(a->excess, larger(a->excess, excess), violated);
}

// Seven planes of one number a lane.
static inline void audit_store(const audit *a, __global uint *faults, size_t plane) {
    store_count(a->nan, faults);
    store_count(a->infinite, faults + plane);
    store_count(a->negative, faults + 2 * plane);
    store_count(a->unfinished, faults + 3 * plane);
    store_count(a->violations, faults + 4 * plane);
    store_bits(a->touched, faults + 5 * plane);
    store_bits(a->excess, faults + 6 * plane);
}
#line 4 "integrator/volumetric_path.cl"

#line 1 "core/moments.h"
// Sum and sum of squares of a pixel's samples as unevaluated pairs of floats (about 48 bits): a range of samples gives
// the same numbers, to the rounding of a float64 sum, however it is cut. Two-sum: Knuth; fast two-sum: Dekker (1971).
typedef struct { real sum, sum_low, square, square_low; } moments;

// Adds x, and what rounding has left of it elsewhere, to a pair.
static inline void pair_add(real *high, real *low, real x, real rest) {
    real s = *high + x, b = s - *high;
    real error = ((*high - (s - b)) + (x - b)) + (*low + rest);
    *high = s + error;
    *low = error - (*high - s);
}

static inline void moments_add(moments *m, real x) {
    real square = x * x;
    pair_add(&m->sum, &m->sum_low, x, (real)0.f);
    pair_add(&m->square, &m->square_low, square, fma(x, x, -square));
}

// Four planes of one number a lane.
static inline void moments_store(const moments *m, __global float *film, size_t plane) {
    store_pair(m->sum, m->sum_low, film, plane);
    store_pair(m->square, m->square_low, film + 2 * plane, plane);
}
#line 6 "integrator/volumetric_path.cl"



// The camera ray of the path's sample, from where it enters the volume; one that misses gets an exit behind it.
static inline void path_begin(path *p, const struct world *world, integer x, integer y, mask begin) {
    p->random.dimension = pick(p->random.dimension, (word)0u, begin);
    words w = rng_next(&p->random, begin);
    int width = world->scene->film.width, height = world->scene->film.height;
    vector anchor, direction;
    real near, far = (real)1e30f;
    camera_ray(world, (to_real(x) + unit(w.x)) / (float)width, (to_real(y) + unit(w.y)) / (float)height, &anchor, &direction, &near);
    vector local_anchor = affine_point(volume_to_local(world), anchor), along = affine_direction(volume_to_local(world), direction);
    box_clip(volume_size(world), local_anchor, along, &near, &far);
    p->origin = vector_pick(p->origin, vector_along(local_anchor, near, along), begin);
    p->direction = vector_pick(p->direction, direction, begin);
    p->along = vector_pick(p->along, along, begin);
    p->t_exit = pick(p->t_exit, far - near, begin);
    p->throughput = spectrum_pick(p->throughput, spectrum_grey((real)1.f), begin);
    p->radiance = spectrum_pick(p->radiance, spectrum_grey((real)0.f), begin);
    p->order = pick(p->order, (integer)0, begin);
}

static inline void volumetric_path(const struct world *world, __global float *film, __global uint *faults, uint first, uint samples, integer pixel) {
    const uint lane0 = get_global_id(0) * LANES, pixels = get_global_size(0) * LANES;
    const int width = world->scene->film.width;
    const integer y = pixel / width, x = pixel - y * width;
    const spectrum albedo = volume_albedo(world);

    // Every lane starts its pixel's first sample; paths and flights start at one place, which is inlined.
    path p = {{(word)0u}};
    flight f = {0};
    p.random.pixel = integer_as_word(pixel);
    p.random.sample = (word)first;
    p.random.dimension = (word)0u;
    p.random.seed = world->scene->film.seed;
    mask live = (mask)-1, begin = live, fresh = live;
    next_event event = {0};
    moments sums[CHANNELS] = {{0}};
    audit found = {0};
    const word last = (word)(first + samples - 1u);

    while (some(live)) {
        if (some(begin)) path_begin(&p, world, x, y, begin);
        if (some(fresh)) flight_start(&f, &p, world, fresh);
        begin = fresh = (mask)0;

        // Tentative collision, of a flight or of a shadow walk.
        words w = rng_next(&p.random, (mask)-1);
        real u, depth = rng_flight(&p.random, w, &u);
        mask escape = flight_step(&f, &p, world, depth);
        vector at = vector_along(p.origin, pick(p.t, p.t_exit, escape), p.along);
        real density = flight_density(&f, world, at, w);
        audit_majorant(&found, density, spectrum_max(p.throughput), live & ~escape & test(density > 1.000001f));
        mask flying = live & ~next_event_walking(&event);
        mask collide = free_flight_collides(density, u) & ~escape & flying;
        mask leave = escape & flying;
        mask scatter = next_event_step(&event, world, &p, density, escape, u);
        if (!some(collide | leave | scatter)) continue;

        // Collision: absorb by weight; faint paths play roulette.
        words v = rng_next(&p.random, collide | leave | scatter);
        p.throughput = spectrum_pick(p.throughput, spectrum_multiply(p.throughput, albedo), collide);
        real chance = roulette_chance(spectrum_max(p.throughput));
        mask dead = collide & test(unit(v.x) >= chance);
        p.throughput = spectrum_pick(p.throughput, spectrum_scale(p.throughput, 1.f / chance), collide & ~dead);
        p.origin = vector_pick(p.origin, at, collide);
        scatter |= next_event_start(&event, world, &p, collide & ~dead, unit(v.y), u / density);

        // Scattering: a new direction.
        vector direction = path_scatter(&p, world, v, scatter);
        p.direction = vector_pick(p.direction, direction, scatter);
        p.along = vector_pick(p.along, affine_direction(volume_to_local(world), p.direction), scatter);
        fresh = collide | scatter;
        p.t_exit = pick(p.t_exit, flight_exit(world, &p), fresh);

        // End of the path: the environment, the film, the next sample of the pixel.
        mask end = leave | dead;
        if (some(end)) {
            spectrum sky = spectrum_multiply(p.throughput, light_radiance(world, p.direction));
            spectrum total = spectrum_pick(p.radiance, spectrum_add(p.radiance, sky), leave);
            mask bad = (mask)0;
            for (int c = 0; c < CHANNELS; ++c) {
                real value = spectrum_channel(total, c);
                mask wrong = end & ~bad & ~(test(value >= 0.f) & test(value < INFINITY));
                audit_value(&found, value, wrong);
                bad |= wrong;
            }
            for (int c = 0; c < CHANNELS; ++c)
                moments_add(&sums[c], pick((real)0.f, spectrum_channel(total, c), end & ~bad));
            live &= ~(end & test(p.random.sample == last));
            p.random.sample = pick(p.random.sample, p.random.sample + 1u, end);
            begin = end;
            fresh |= end;
        }
    }

    for (int c = 0; c < CHANNELS; ++c) moments_store(&sums[c], film + (size_t)(4 * c) * pixels + lane0, pixels);
    audit_store(&found, faults + lane0, pixels);
}
#line 1 "generated"

__kernel void render(__constant const struct scene *scene, __global float *film, __global uint *faults, uint first, uint samples) {
    const struct world world = {scene};
    volumetric_path(&world, film, faults, first, samples, (int)get_global_id(0) * LANES + lane_index());
}
