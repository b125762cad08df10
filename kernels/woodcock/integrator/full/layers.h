// Layers beside the beauty: orders of scattering, and what camera rays meet first. The generated enumeration says at which
// channel each begins, or -1. What a ray does not meet counts as zero, so layers of what it meets are premultiplied by
// how much there is of it.
static inline void layer_add(path *p, int at, real value, mask chosen) {
    p->layers.value[at] += pick((real)0.f, value, chosen);
}

static inline void layer_add_spectrum(path *p, int at, spectrum value, mask chosen) {
    for (int c = 0; c < CHANNELS; ++c) layer_add(p, at + c, spectrum_channel(value, c), chosen);
}

static inline void layer_add_vector(path *p, int at, vector value, mask chosen) {
    layer_add(p, at, value.x, chosen);
    layer_add(p, at + 1, value.y, chosen);
    layer_add(p, at + 2, value.z, chosen);
}

static inline void path_gain(path *p, spectrum gained, integer order, mask chosen) {
    p->radiance = spectrum_pick(p->radiance, spectrum_add(p->radiance, gained), chosen);
    for (int k = 0; k < ORDERS; ++k) {
        mask here = k < ORDERS - 1 ? test(order == k) : test(order >= k);
        layer_add_spectrum(p, k * CHANNELS, gained, chosen & here);
    }
}

// A walk along the camera ray measures its transmittance and optical depth before the path sets out.
static inline mask walk_may_be_cut(const path *p) { return ~p->layers.probing; }

static inline void walk_pass_media(path *p, coefficient depth, mask walking) {
    if (OPTICAL_DEPTH >= 0) layer_add(p, OPTICAL_DEPTH, coefficient_mean(depth), walking & p->layers.probing);
}

static inline void walk_pass(path *p, coefficient sigma_t, real bound, mask walking) {
    walk_pass_media(p, coefficient_scale(sigma_t, 1.f / bound), walking);
}

static inline void layers_begin(path *p, const struct world *world, real lead, mask begin) {
    for (int k = 0; k < LAYERS; ++k) p->layers.value[k] = pick(p->layers.value[k], (real)0.f, begin);
    p->layers.lead = pick(p->layers.lead, lead, begin);
    p->layers.start = vector_pick(p->layers.start, p->origin, begin);
    p->layers.unmet |= begin;
    if ((TRANSMITTANCE >= 0) | (OPTICAL_DEPTH >= 0)) {
        p->layers.probing |= begin;
        p->aside |= begin;
        p->position = vector_pick(p->position, p->origin, begin);
        p->incoming = vector_pick(p->incoming, p->direction, begin);
        p->inside_there = pick(p->inside_there, p->inside, begin);
        real length = p->length;
        walk_start(p, p->direction, length, begin);
    }
}

// Ends the walks along camera rays; what a surface stops lets nothing through. Returns the lanes that were on such walks.
static inline mask layers_probed(path *p, mask walked, mask gone) {
    mask probed = walked & p->layers.probing;
    if (TRANSMITTANCE >= 0) layer_add(p, TRANSMITTANCE, coefficient_mean(p->transmittance), probed & gone);
    p->layers.probing &= ~probed;
    return probed;
}

static inline real layer_value(const path *p, int k) { return p->layers.value[k]; }

static inline void layers_met(path *p, const struct world *world, vector normal, mask vertex) {
    mask first = vertex & p->layers.unmet;
    if (DEPTH >= 0) {
        vector flown = vector_along(p->position, (real)-1.f, p->layers.start);
        layer_add(p, DEPTH, p->layers.lead + sqrt(vector_dot(flown, flown)), first);
    }
    if (POSITION >= 0) {
        vector centre = vector_uniform(world->scene->bounds.centre);
        layer_add_vector(p, POSITION, vector_along(centre, (real)world->scene->bounds.unit, p->position), first);
    }
    if (NORMAL >= 0) layer_add_vector(p, NORMAL, normal, first & test(p->medium < 0));
    p->layers.unmet &= ~first;
}

// The share of light that the first vertex scatters: the mean of the weights that scattering gives.
static inline void layers_scattered(path *p, mask scatter) {
    if (ALBEDO >= 0) layer_add_spectrum(p, ALBEDO, p->throughput, scatter & test(p->order == 0));
}
