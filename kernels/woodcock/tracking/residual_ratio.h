// Transmittance by residual ratio tracking: Novák, Selle & Jarosz, "Residual ratio tracking for estimating attenuation in
// participating media", SIGGRAPH Asia 2014. A control is passed in closed form; tentative collisions, at the rate of a bound on
// what σ_t is above it, multiply by 1 - residual / bound.
//
// The control is a lower bound on σ_t. A walk's relative variance is exp(∫ (σ_t - control)² / bound) - 1: with this control it
// is nowhere more than ratio tracking's, and no weight is negative or above 1. A control in the middle would have less where
// σ_t is near it, and no end of it on rays through the thin part of a cell.
static inline real transmittance_residual_ratio_factor(real residual, real bound) { return larger((real)0.f, 1.f - residual / bound); }

// What gets through the control.
static inline coefficient transmittance_residual_ratio_control(coefficient depth) { return coefficient_exp_minus(depth); }
