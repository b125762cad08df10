// A Gaussian, cut off at four standard deviations. Its distribution function is inverted by the approximation of
// erf⁻¹ of Giles, "Approximating the erfinv function", GPU Computing Gems 2, 2011, for single precision.
static inline real filter_gaussian_offset(__constant const struct filter_gaussian *filter, real u) {
    // From the nearer end, so that 1 - y² keeps its digits: the tail cut off has 3.167e-5, what is kept 0.99993666.
    mask left = test(u < 0.5f);
    real q = pick(1.f - u, u, left);
    real p = 3.16712418e-5f + 0.999936658f * q, y = 0.999936658f * (1.f - 2.f * q);
    real w = -log(4.f * p * (1.f - p)), c = w - 2.5f, t = sqrt(larger(w, (real)5.f)) - 3.f;
    real middle = 1.50140941f + c * (0.246640727f + c * (-0.00417768164f + c * (-0.00125372503f + c * (0.00021858087f
                + c * (-4.39150654e-6f + c * (-3.5233877e-6f + c * (3.43273939e-7f + c * 2.81022636e-8f)))))));
    real tail = 2.83297682f + t * (1.00167406f + t * (0.00943887047f + t * (-0.0076224613f + t * (0.00573950773f
              + t * (-0.00367342844f + t * (0.00134934322f + t * (0.000100950558f + t * -0.000200214257f)))))));
    real deviations = 1.41421356f * y * pick(tail, middle, test(w < 5.f));
    return filter->deviation * pick(deviations, -deviations, left);
}

static inline real filter_gaussian_pdf(__constant const struct filter_gaussian *filter, real offset) {
    real x = offset / filter->deviation;
    real density = 0.398967552f / filter->deviation * exp(-0.5f * x * x);
    return pick((real)0.f, density, test(fabs(x) <= 4.00001f));
}
