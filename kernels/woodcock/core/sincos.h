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
