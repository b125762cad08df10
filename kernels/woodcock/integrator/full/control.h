// What free flights and transmittances share that have a control: a lower bound on the σ_t of all grids in the walk's cell.
#include "core/audit.h"

static inline coefficient control_residual(coefficient sigma_t, coefficient minorant) {
    coefficient residual;
    for (int c = 0; c < COEFFICIENTS; ++c)
        coefficient_channel(residual, c) = larger((real)0.f, coefficient_channel(sigma_t, c) - coefficient_channel(minorant, c));
    return residual;
}

// A control above σ_t is a bias, as a majorant below it is, and counted with these.
static inline void audit_minorant(audit *found, coefficient sigma_t, coefficient minorant, real throughput, mask event) {
    mask above = (mask)0;
    for (int c = 0; c < COEFFICIENTS; ++c)
        above |= test(coefficient_channel(sigma_t, c) < coefficient_channel(minorant, c) * 0.999999f);
    audit_majorant(found, (real)1.f, throughput, event & above);
}
