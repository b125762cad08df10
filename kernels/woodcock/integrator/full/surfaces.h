// Surfaces: where a segment ends at one, what shines there, and how paths leave it.
typedef struct {
    surface_hit hit;       // of the segment
    surface_point at;      // of the vertex
    integer bounces;       // since a path came to surfaces; a mirror box would keep it for ever
} surface_state;

// Meetings with surfaces after which a path is given up and counted as rejected.
#define MOST_BOUNCES 65536

static inline void surfaces_ahead(surface_state *s, path *p, const struct world *world, real *end, mask fresh) {
    surface_hit hit = surface_intersect(world, p->origin, p->direction, p->length, fresh);
    s->hit.t = pick(s->hit.t, hit.t, fresh);
    s->hit.primitive = pick(s->hit.primitive, hit.primitive, fresh);
    s->hit.u = pick(s->hit.u, hit.u, fresh);
    s->hit.v = pick(s->hit.v, hit.v, fresh);
    *end = smaller(*end, hit.t);
    // A ray that meets nothing for ever is outside all meshes, whatever rounding has made of a face that it started on.
    p->inside = pick(p->inside, (word)0u, fresh & test(p->length >= 1e30f) & test(hit.t >= 1e30f));
}

static inline mask surfaces_met(const surface_state *s, mask arrived) { return arrived & test(s->hit.t < 1e30f); }

// Lanes that have met a surface: index-matched ones let everything pass, others end a walk and are a flight's vertex.
static inline mask surfaces_meet(surface_state *s, path *p, const struct world *world, mask met, mask *lost) {
    if (!some(met)) return (mask)0;
    surface_point at = surface_locate(world, s->hit, p->origin, p->direction);
    mask pass = met & material_is_null(world, at.surface);
    p->origin = vector_pick(p->origin, surface_leave(at, p->direction), pass);
    p->length = pick(p->length, p->length - p->end, pass & test(p->length < 1e30f));
    p->inside = pick(p->inside, p->inside ^ integer_as_word(surface_media(world, at.surface)), pass);
    p->fresh |= pass;
    p->asked &= ~pass | p->walking;  // a flight's next segment has a vertex of its own, but not because of its walk
    *lost |= met & ~pass & p->walking;
    mask vertex = met & ~pass & ~p->walking;
    if (some(vertex)) {
        spectrum shine = material_emission(world, at.surface, p->direction, at.geometric);
        real pdf = surface_emission_pdf(world, s->hit, p->departed, at, p->direction);
        real weight = p->pdf / (p->pdf + pdf);
        path_gain(p, spectrum_scale(spectrum_multiply(p->throughput, shine), weight), p->order, vertex);
        s->at.position = vector_pick(s->at.position, at.position, vertex);
        s->at.geometric = vector_pick(s->at.geometric, at.geometric, vertex);
        s->at.shading = vector_pick(s->at.shading, at.shading, vertex);
        s->at.error = pick(s->at.error, at.error, vertex);
        s->at.surface = pick(s->at.surface, at.surface, vertex);
        s->bounces = pick(s->bounces, s->bounces + 1, vertex);
        p->position = vector_pick(p->position, at.position, vertex);
        p->medium = pick(p->medium, (integer)-1, vertex);
    }
    return vertex;
}

static inline mask surfaces_scatter_anywhere(const surface_state *s, const struct world *world) {
    return ~material_is_delta(world, s->at.surface);
}

static inline vector surfaces_normal(const surface_state *s) { return s->at.shading; }

static inline mask surfaces_given_up(surface_state *s, mask begin) {
    mask up = test(s->bounces >= MOST_BOUNCES);
    s->bounces = pick(s->bounces, (integer)0, begin);
    return up;
}

static inline void surfaces_eval(const surface_state *s, const path *p, const struct world *world, vector towards,
                                 spectrum *value, real *pdf, mask at_surface) {
    if (!some(at_surface)) return;
    spectrum reflected;
    real density;
    surface_scatter_eval(p, world, &s->at, towards, &reflected, &density);
    *value = spectrum_pick(*value, reflected, at_surface);
    *pdf = pick(*pdf, density, at_surface);
}

// Sets out from a surface along `direction`, through it or not: closed meshes of media are entered or left.
static inline void surfaces_depart(const surface_state *s, path *p, const struct world *world, mask leaving) {
    if (!some(leaving)) return;
    mask through = test(vector_dot(p->incoming, s->at.geometric) * vector_dot(p->direction, s->at.geometric) > 0.f);
    p->inside = pick(p->inside, p->inside ^ integer_as_word(surface_media(world, s->at.surface)), leaving & through);
    p->origin = vector_pick(p->origin, surface_leave(s->at, p->direction), leaving);
}

// A new direction for paths on surfaces.
static inline void surfaces_scatter(surface_state *s, path *p, const struct world *world, mask scatter) {
    if (!some(scatter)) return;
    words w = rng_next(&p->random, scatter);
    vector out;
    spectrum weight;
    real pdf;
    surface_scatter(p, world, &s->at, w, &out, &weight, &pdf);
    flight_start(p, out, scatter);
    p->throughput = spectrum_pick(p->throughput, spectrum_multiply(p->throughput, weight), scatter);
    p->pdf = pick(p->pdf, pick((real)1e30f, pdf, test(pdf > 0.f)), scatter);
    surfaces_depart(s, p, world, scatter);
}
