// One step of an exponential integrator for L′ + σ_t L = ε (Hochbruck & Ostermann, Acta Numerica 19, 2010; along the ray
// away from the eye): gain = ∫₀ʰ ε(s) exp(-τ(s)) ds, of any stiffness z = τ(h). With u = s/h, exp(-z u) is integrated exactly
// against the polynomial through the values at five nodes of all that is left, ε exp(z u - τ). The nodes are those of
// Kronrod's rule of five points, so that τ is exact for a σ_t of up to seventh degree, and its ends are never asked for,
// where σ_t or ε may jump.
// The result is divided by what the same rule gives for σ_t in place of ε, and multiplied by what is exact for it,
// 1 - exp(-z) by expm1: a medium in which ε / σ_t is a constant gets its exact radiance whatever σ_t does.
// The error is three times how far three rules of three of the nodes are off: one alone may agree by chance, as it does
// for a twentieth of the rays through a grid of noise with τ about 100, three of them never did in 60000.
__constant const number exponential_node[5] = {0.03708995011372427, 0.2113248654051871, 0.5, 0.7886751345948129, 0.9629100498862757};
__constant const number exponential_weight[5] = {0.09898989898989899, 0.24545454545454545, 0.3111111111111111, 0.24545454545454545, 0.09898989898989899};
// ∫ of the Lagrange polynomial of node k from 0 to node j.
__constant const number exponential_until[5][5] = {
    {0.04476064216656713, -0.01134567018133403, 0.0056608727352377, -0.0029103578068102767, 0.0009244632000637459},
    {0.11153687708025325, 0.11485431451105056, -0.02192619386199607, 0.009881538294754964, -0.003021670618875589},
    {0.09245440488212281, 0.2703452392814384, 0.15555555555555556, -0.024890693826892952, 0.006535494107776179},
    {0.10201156960877458, 0.2355730071597905, 0.3330373049731072, 0.1306002309434949, -0.012546978090354263},
    {0.09806543578983525, 0.24836490326135574, 0.30545023837587343, 0.25680021563587946, 0.05422925682333186}};
// Coefficients of the Lagrange polynomials of all nodes.
__constant const number exponential_five[5][5] = {
    {1.4297755286190155, -12.923052713800608, 37.61474739393016, -43.884579070700916, 17.818181818181817},
    {-0.6452796555775742, 20.176571485509044, -78.74894561397078, 104.86293343961688, -45.81818181818182},
    {0.3333333333333333, -11.333333333333334, 67.33333333333333, -112.0, 56.0},
    {-0.17290216260424401, 6.005246696309138, -39.069236204211045, 78.40979383311038, -45.81818181818182},
    {0.055072956229469366, -1.9254321346842398, 12.870101090918327, -27.38814820202636, 17.818181818181817}};
// Of three nodes, for three choices of them.
__constant const int exponential_chosen[3][3] = {{0, 2, 4}, {0, 1, 3}, {1, 2, 3}};
__constant const number exponential_three[3][3][3] = {
    {{1.123395058200655, -3.4134567830679767, 2.3333333333333335},
     {-0.16666666666666666, 4.666666666666667, -4.666666666666667},
     {0.04327160846601165, -1.25320988359869, 2.3333333333333335}},
    {{1.2727272727272727, -7.636363636363637, 7.636363636363637},
     {-0.290790247153909, 8.208843098061209, -9.940893905630086},
     {0.018062974426636277, -0.5724794616975722, 2.3045302692664493}},
    {{2.366025403784439, -7.732050807568878, 6.0},
     {-2.0, 12.0, -12.0},
     {0.6339745962155614, -4.267949192431122, 6.0}}};

// moment[k] = ∫₀¹ exp(-z u) uᵏ du. Upwards from expm1 where z divides well; for small z downwards from the last one's
// series exp(-z) (1 + z/6 (1 + z/7 (1 + …))) / 5, whose terms are positive: neither cancels.
static inline void exponential_moments(real z, real moment[5]) {
    real decay = exp(-z), up[5], down[5], series = (real)(number)(1.0 / 25);
    for (int n = 24; n >= 5; --n) series = (1.f + z * series) / (number)n;
    down[4] = decay * series;
    for (int k = 4; k > 0; --k) down[k - 1] = (z * down[k] + decay) / (number)k;
    up[0] = -expm1(-z) / z;
    for (int k = 1; k < 5; ++k) up[k] = ((number)k * up[k - 1] - decay) / z;
    mask small = test(z < 2.f);
    for (int k = 0; k < 5; ++k) moment[k] = pick(up[k], down[k], small);
}

// `found` times what is exact for σ_t over what the rule found for it.
static inline real exponential_corrected(real found, real found_sigma, real exact) {
    mask usable = test(found_sigma > 0.f);
    return pick(found, found * (exact / pick((real)1.f, found_sigma, usable)), usable);
}

// sigma, epsilon: at the nodes; returns z. `resolved` is false where exp(z u - τ) varies more over the step than a
// polynomial follows, so that both rules may miss the same: the error means nothing then.
static inline real exponential_step(const real sigma[5], const real epsilon[5], real length, real *gain, real *error, mask *resolved) {
    *resolved = (mask)-1;
    real z = (real)0.f, moment[5], left[5], five = (real)0.f, five_sigma = five;
    for (int k = 0; k < 5; ++k) z += exponential_weight[k] * sigma[k];
    z *= length;
    exponential_moments(z, moment);
    for (int j = 0; j < 5; ++j) {
        real tau = (real)0.f;
        for (int k = 0; k < 5; ++k) tau += exponential_until[j][k] * sigma[k];
        real varies = exponential_node[j] * z - tau * length;
        varies = pick(varies, (real)0.f, test(fabs(varies) <= z * (16.f * EPSILON)));  // rounding, in a stiff constant
        *resolved &= test(fabs(varies) < 0.5f);
        left[j] = exp(larger(smaller(varies, (real)2.f), (real)-2.f));
        real weight = (real)0.f;
        for (int k = 0; k < 5; ++k) weight += exponential_five[j][k] * moment[k];
        five += weight * left[j] * epsilon[j];
        five_sigma += weight * left[j] * sigma[j];
    }
    real exact = -expm1(-z);
    *gain = exponential_corrected(five * length, five_sigma * length, exact);
    *error = (real)0.f;
    for (int rule = 0; rule < 3; ++rule) {
        real three = (real)0.f, three_sigma = three;
        for (int j = 0; j < 3; ++j) {
            const int node = exponential_chosen[rule][j];
            real weight = (real)0.f;
            for (int k = 0; k < 3; ++k) weight += exponential_three[rule][j][k] * moment[k];
            three += weight * left[node] * epsilon[node];
            three_sigma += weight * left[node] * sigma[node];
        }
        *error += 3.f * fabs(*gain - exponential_corrected(three * length, three_sigma * length, exact));
    }
    return z;
}
