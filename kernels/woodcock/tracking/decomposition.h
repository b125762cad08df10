// Free flight by decomposition tracking: Kutz, Habel, Li & Novák, "Spectral and decomposition tracking for rendering
// heterogeneous volumes", SIGGRAPH 2017. σ_t is a control, which is known, and a residual. The clocks of both ring together
// as one of the majorant's rate does, and a tentative collision whose level, uniform up to the majorant, lies below the
// control is the control's: real, and not looked up. So flights are delta tracking's own, to the last bit.
static inline mask free_flight_decomposition_known(real level, real minorant) { return test(level < minorant); }

// One that is looked up is the residual's, or null.
static inline mask free_flight_decomposition_collides(real level, real sigma_t) { return test(level < sigma_t); }
