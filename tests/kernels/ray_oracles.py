"""Media along single rays, and their optical depths and radiance in float64: grids are looked up by scipy and
integrated between all planes, by no code of ours.

A ray is six float32 numbers, origin and direction; positions are origin + t direction, for t from 0 on.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.ndimage import map_coordinates

from woodcock.layout import module
from woodcock.scene import BoxShape, SphereShape
from woodcock.space import Array

NONE = np.zeros(1)


@dataclass(frozen=True)
class Homogeneous:
    shape: BoxShape | SphereShape
    sigma: Any
    epsilon: Any = 0.0

    def interval(self, origin: Array, along: Array) -> tuple[float, float]:
        near, far = module("shape", self.shape.kind).interval(self.shape, origin[None], along[None])
        return (float(near[0]), float(far[0])) if near[0] < far[0] else (np.inf, -np.inf)

    def kinks(self, origin: Array, along: Array) -> list[float]:
        return []

    def at(self, p: Array) -> tuple[Array, Array]:
        shape = (len(p), np.size(self.sigma)), (len(p), np.size(self.epsilon))
        return np.broadcast_to(self.sigma, shape[0]), np.broadcast_to(self.epsilon, shape[1])


@dataclass(frozen=True)
class Gridded:
    """values: [z][y][x]; σ = sigma × value; ε = epsilon × value², which no rule for cubics is made for, or × value."""

    values: Any
    to_scene: Array
    sigma: Any = 1.0
    epsilon: Any = 0.0
    nearest: bool = False
    isothermal: bool = False

    def local(self, origin: Array, along: Array) -> tuple[Array, Array]:
        matrix = np.linalg.inv(self.to_scene)
        return origin @ matrix[:3, :3].T + matrix[:3, 3], along @ matrix[:3, :3].T

    def interval(self, origin: Array, along: Array) -> tuple[float, float]:
        o, d = self.local(origin, along)
        near, far = 0.0, np.inf
        for o_axis, d_axis, n in zip(o, d, self.values.shape[::-1], strict=True):
            if d_axis == 0:
                if not 0 <= o_axis <= n:
                    return np.inf, -np.inf
                continue
            a, b = sorted([-o_axis / d_axis, (n - o_axis) / d_axis])
            near, far = max(near, a), min(far, b)
        return (near, far) if near < far else (np.inf, -np.inf)

    def kinks(self, origin: Array, along: Array) -> list[float]:
        o, d = self.local(origin, along)
        found: list[float] = []
        for o_axis, d_axis, n in zip(o, d, self.values.shape[::-1], strict=True):
            if d_axis != 0:
                found += ((np.arange(n) + (0 if self.nearest else 0.5) - o_axis) / d_axis).tolist()
        return found

    def at(self, p: Array) -> tuple[Array, Array]:
        local, _ = self.local(p, p)
        order, index = (0, np.floor(local)) if self.nearest else (1, local - 0.5)
        value = map_coordinates(np.asarray(self.values, float), index.T[::-1], order=order, mode="nearest")[:, None]
        return value * np.atleast_1d(self.sigma), (value if self.isothermal else value**2) * np.atleast_1d(self.epsilon)


Media = list[Homogeneous | Gridded]

# Oracles


def pieces(media: Media, ray: Array) -> tuple[Array, list[tuple[float, float]]]:
    """Where the coefficients along a ray may have kinks or jumps, and the media's intervals."""
    origin, along = ray[:3].astype(float), ray[3:].astype(float)
    spans = [medium.interval(origin, along) for medium in media]
    ends = [max(t, 0.0) for span in spans if span[0] < span[1] for t in span]
    kinks = [t for medium in media for t in medium.kinks(origin, along)]
    if not ends:
        return np.zeros(0), spans
    inside = [t for t in kinks if min(ends) < t < max(ends)]
    return np.unique([*ends, *inside]), spans


def coefficients(media: Media, ray: Array, spans: list[tuple[float, float]], a: float, b: float, t: Array) -> Any:
    """σ and ε, (n, 1 or 3), at t within the piece [a, b]."""
    p, middle = ray[:3].astype(float) + t[:, None] * ray[3:].astype(float), (a + b) / 2
    sigma, epsilon = np.zeros((len(t), 1)), np.zeros((len(t), 1))
    for medium, (near, far) in zip(media, spans, strict=True):
        if near < middle < far:
            own = medium.at(p)
            sigma, epsilon = sigma + own[0], epsilon + own[1]
    return sigma, epsilon


def optical_depth(media: Media, ray: Array) -> Array:
    """(1,) or (3,), by Gauss–Legendre of seven points on either half of each piece."""
    bounds, spans = pieces(media, ray)
    x, w = np.polynomial.legendre.leggauss(7)
    total = NONE
    for a, b in pairwise(bounds):
        for low, high in ((a, (a + b) / 2), ((a + b) / 2, b)):
            sigma, _ = coefficients(media, ray, spans, a, b, low + (high - low) * (x + 1) / 2)
            total = total + (high - low) / 2 * (w @ sigma)
    return total


def emitted(media: Media, ray: Array, behind: float = 0.0) -> float:
    """Grey radiance that reaches the ray's origin, to about 1e-8: scipy's Radau on L′ + σ L = ε towards the camera,
    from the far end or from where an optical depth of 40 hides the rest."""
    bounds, spans = pieces(media, ray)
    radiance, depth, seen = np.array([behind]), 0.0, []
    for a, b in pairwise(bounds):
        if depth < 40:
            seen.append((a, b))
            depth += (b - a) * float(coefficients(media, ray, spans, a, b, np.linspace(a, b, 9)[1:-1])[0].mean())
    for a, b in reversed(seen):

        def slope(s: float, y: Array, a: float = a, b: float = b) -> Array:
            sigma, epsilon = coefficients(media, ray, spans, a, b, np.array([b - s]))
            return np.asarray(epsilon[0] - sigma[0] * y)

        scale = max(float(radiance[0]), 1e-30)
        radiance = solve_ivp(slope, (0, b - a), radiance, "Radau", rtol=1e-9, atol=scale * 1e-10).y[:, -1]
    return float(radiance[0])
