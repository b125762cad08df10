"""The classical methods, in float64, from the far end of the ray to the eye. t = 1 - s is the time of L′ = q - σ_t L.

A one-step method takes the linear equation from L to a L + b, so each is its a and b; an evaluation is one of (σ_t, q).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from studies.stiff.problems import Array, Problem

Steps = tuple[Array, Array, int]


def explicit_euler(problem: Problem, n: int) -> Steps:
    h = 1 / n
    sigma, q = problem.at(np.arange(1, n + 1) / n)
    return 1 - h * sigma, h * q, n


def implicit_euler(problem: Problem, n: int) -> Steps:
    h = 1 / n
    sigma, q = problem.at(np.arange(n) / n)
    return 1 / (1 + h * sigma), h * q / (1 + h * sigma), n


def rk4(problem: Problem, n: int) -> Steps:
    """The end of a step is the beginning of the next: two evaluations a step."""
    h = 1 / n
    ends, middle = problem.at(np.arange(n + 1) / n), problem.at((np.arange(n) + 0.5) / n)
    far, near = ([values[1:] for values in ends], [values[:-1] for values in ends])

    def step(y: float, lit: float) -> Array:
        def slope(at: Any, y: Any) -> Array:
            return np.asarray(lit * at[1] - at[0] * y)

        k1 = slope(far, y)
        k2 = slope(middle, y + h / 2 * k1)
        k3 = slope(middle, y + h / 2 * k2)
        k4 = slope(near, y + h * k3)
        return np.asarray(y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4))

    return step(1.0, 0.0), step(0.0, 1.0), 2 * n + 1


def ray_marching(problem: Problem, n: int) -> Steps:
    """At the middle of each step, L += T ε h and T *= exp(-σ_t h): the same sum from back to front."""
    sigma, q = problem.at((np.arange(n) + 0.5) / n)
    return np.exp(-sigma / n), q / n, n


def ray_marching_opacity(problem: Problem, n: int) -> Steps:
    """The better variant: a step of colour ε / σ_t and opacity 1 - exp(-σ_t h); where σ_t = 0 it has no colour."""
    sigma, q = problem.at((np.arange(n) + 0.5) / n)
    colour = np.divide(q, sigma, out=np.zeros(n), where=sigma > 0)
    return np.exp(-sigma / n), colour * (1 - np.exp(-sigma / n)), n


METHODS: dict[str, Callable[[Problem, int], Steps]] = {
    "explicit Euler": explicit_euler,
    "RK4": rk4,
    "implicit Euler": implicit_euler,
    "ray marching": ray_marching,
    "ray marching, opacity": ray_marching_opacity,
}


def solve(method: str, problem: Problem, n: int) -> tuple[float, int]:
    """L(0) by n steps of one length, and the evaluations; infinity where the method blew up."""
    with np.errstate(over="ignore", invalid="ignore"):
        a, b, evaluations = METHODS[method](problem, n)
    radiance = problem.behind
    for factor, gain in zip(a[::-1].tolist(), b[::-1].tolist(), strict=True):
        radiance = factor * radiance + gain
    return (radiance if np.isfinite(radiance) else np.inf), evaluations


def radau(problem: Problem, tolerance: float = 1e-12) -> tuple[float, int]:
    """L(0) by scipy's Radau (Radau IIA of fifth order, adaptive), begun anew at every edge, and the evaluations."""
    evaluations, radiance = 0, np.array([problem.behind])
    scale = max(problem.behind, float(np.max(problem.q / np.maximum(problem.sigma, 1))))
    for piece in reversed(range(len(problem.sigma))):
        far, here = problem.edges[piece + 1], np.array([piece])

        def at(t: float, far: float = far, here: NDArray[np.intp] = here) -> tuple[float, float]:
            nonlocal evaluations
            evaluations += 1
            sigma, q = problem.at(np.array([far - t]), here)
            return float(sigma[0]), float(q[0])

        def slope(t: float, y: Array, at: Any = at) -> Array:
            sigma, q = at(t)
            return np.asarray(q - sigma * y)

        def jacobian(t: float, y: Array, at: Any = at) -> Array:
            return np.array([[-at(t)[0]]])

        length = far - problem.edges[piece]
        solution = solve_ivp(
            slope, (0, length), radiance, "Radau", jac=jacobian, rtol=tolerance, atol=scale * tolerance
        )
        if not solution.success:
            raise RuntimeError(f"Radau failed on {problem.name}: {solution.message}")
        radiance = solution.y[:, -1]
    return float(radiance[0]), evaluations
