// The angle of (x, y) from the x axis, -π to π, as atan2 gives it: reduced to below π/8, then a minimax polynomial
// (Cephes atanf), with one division and no call. Relative precision for small angles; 0 for (0, 0).
static inline real angle_of(real y, real x) {
    real across = fabs(x), along = fabs(y);
    mask steep = test(along > across);
    real low = pick(along, across, steep), high = pick(across, along, steep);
    mask diagonal = test(low > 0.414213562f * high);
    real above = pick(low, low - high, diagonal), below = pick(high, low + high, diagonal);
    real t = above / pick(below, (real)1.f, test(below == 0.f)), t2 = t * t;
    real poly = ((8.05374449538e-2f * t2 - 1.38776856032e-1f) * t2 + 1.99777106478e-1f) * t2 - 3.33329491539e-1f;
    real angle = t + t * t2 * poly;
    angle = pick(angle, angle + 0.785398163f, diagonal);
    angle = pick(angle, 1.57079633f - angle, steep);
    return copysign(pick(angle, 3.14159265f - angle, test(x < 0.f)), y);
}
