// Free flight in a homogeneous medium: the majorant is σ_t itself, so every tentative collision is real.
static inline mask free_flight_analytic_collides(real density, real u) { return (mask)-1; }
