// Free flight in a homogeneous medium: the majorant is σ_t, and collisions are real.
static inline mask free_flight_analytic_collides(real density, real u) { return (mask)-1; }
