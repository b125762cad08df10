"""Exact answers, in float64, by formulas that share nothing with the kernels."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Slabs


def slab(tau: float, background: float = 0.0) -> float:
    """L = B (1 - e^-τ) + L_e e^-τ, of a source function B = 1 before L_e."""
    return -math.expm1(-tau) + background * math.exp(-tau)


def slab_spread(tau: float) -> float:
    """Standard deviation of min(t, τ), t exponential with mean 1: of what flights gather in a slab of B = 1."""
    if tau < 1e-3:  # the difference below cancels: τ³/3 - 5 τ⁴/12 + …
        return math.sqrt(tau**3 / 3 * (1 - 5 * tau / 4))
    return math.sqrt(2 * (1 - math.exp(-tau) * (1 + tau)) - math.expm1(-tau) ** 2)


def half_space(albedo: float, mu: float = 1.0) -> float:
    """Radiance that leaves an isotropic half-space at cosine mu under a uniform sky of 1: 1 - √(1 - ω) H(μ).

    Chandrasekhar, Radiative Transfer (1950): 1/H(μ) = √(1 - ω) + ω/2 ∫₀¹ μ′ H(μ′) / (μ + μ′) dμ′, by iteration.
    """
    nodes, weights = _gauss(64)
    root = math.sqrt(1 - albedo)
    h = np.ones(nodes.size)
    for _ in range(2000):
        before, h = h, 1 / (root + albedo / 2 * (weights * nodes * h / (nodes[:, None] + nodes)).sum(axis=1))
        if np.abs(h - before).max() < 1e-14:
            break
    return 1 - root / (root + albedo / 2 * float((weights * nodes * h / (mu + nodes)).sum()))


@cache
def lit_slab(albedo: float, g: float, tau: float) -> float:
    """Radiance seen straight on of a slab of Henyey–Greenstein scatterers under a uniform sky of 1 on both sides.

    Doubling (van de Hulst 1963; Hansen & Travis, Space Sci. Rev. 16, 1974) of the azimuthal mean in 64 + 64 streams,
    with one more of no weight for the cosine of 1: reflection and transmission of a layer give those of two. 2⁷ terms
    of the phase function: |g| of 0.9 at most.
    """
    nodes, weights = _gauss(64)
    mu, w = np.append(nodes, 1.0), np.append(weights, 0.0)
    degree = np.arange(2 * nodes.size)
    legendre = np.polynomial.legendre.legvander(mu, degree.size - 1)
    terms = (2 * degree + 1) * g**degree
    same, other = (legendre * (terms * sign**degree) @ legendre.T for sign in (1.0, -1.0))
    one, halvings = np.eye(mu.size), 24
    a = (one - albedo / 2 * same * w) / mu[:, None] * (tau / 2**halvings)
    b = (albedo / 2 * other * w) / mu[:, None] * (tau / 2**halvings)
    reflection, lost = b - (a @ b + b @ a) / 2, a - (a @ a + b @ b) / 2
    transmission = one - lost
    for _ in range(halvings):
        between = np.linalg.solve(one - reflection @ reflection, transmission)
        reflection, transmission = reflection + transmission @ reflection @ between, transmission @ between
    return float((reflection + transmission).sum(axis=1)[-1])


def rod(albedo: float, tau: float) -> float:
    """Of media that scatter straight back, under light of 1 at both ends (two streams): R + T."""
    k = math.sqrt(1 - albedo * albedo)
    return (albedo * math.sinh(k * tau) + k) / (k * math.cosh(k * tau) + math.sinh(k * tau))


def henyey_greenstein(g: float, cosine: float) -> float:
    """p, per steradian, of a cosine of 1 or -1."""
    return (1 + g * cosine) / (4 * math.pi * (1 - g * cosine) ** 2)


# Grids that fill the unit cube, values [z][y][x]


def middles(pixels: int) -> Array:
    """Of the pixels of a row, as parts of it."""
    return np.asarray((np.arange(pixels) + 0.5) / pixels)


def interpolated(plane: Array, x: Array, y: Array) -> Array:
    """(y, x, …): bilinear between the middles of a plane's cells [y][x][…], clamped at the border."""
    rows = _between(plane, y)
    return np.swapaxes(_between(np.swapaxes(rows, 0, 1), x), 0, 1)


def column_means(values: NDArray[np.floating], x: Array, y: Array) -> Array:
    """(y, x): ∫ along z, trilinear. Interpolation and clamping leave a column the mean of its voxels."""
    return interpolated(values.astype(float).mean(axis=0), x, y)


def through_columns(values: Array, x: Array, y: Array) -> Array:
    """(y, x): exp(-τ) along z, trilinear."""
    return np.exp(-column_means(values, x, y))


def through_columns_mean(values: Array) -> float:
    """The mean of exp(-τ) along z over the face, trilinear: by 16 Gauss points in every piece of the bilinear depth."""
    depth = values.mean(axis=0)
    (y, wy), (x, wx) = (_pieces(n) for n in depth.shape)
    return float(wy @ np.exp(-interpolated(depth, x, y)) @ wx)


def depth_of_ray(values: Array, origin: Array, direction: Array, *, nearest: bool = False) -> float:
    """∫σ_t along a ray through the unit cube, by two Gauss points between all planes of the grid that it meets."""
    size = np.array(values.shape[::-1], float)
    o, d = np.asarray(origin, float) * size, np.asarray(direction, float) * size
    moving = np.abs(d) > 0
    ends = np.sort(np.stack([-o[moving] / d[moving], (size - o)[moving] / d[moving]]), axis=0)
    near, far = float(ends[0].max()), float(ends[1].min())
    if not near < far or np.any(~moving & ((o < 0) | (o > size))):
        return 0.0
    shift = 0.0 if nearest else 0.5
    planes = [(np.arange(size[i] + 1) - shift - o[i]) / d[i] for i in range(3) if moving[i]]
    cuts = np.concatenate([[near, far], *planes])
    cuts = np.unique(np.clip(cuts, near, far))
    half, middle = np.diff(cuts) / 2, (cuts[1:] + cuts[:-1]) / 2
    found = [
        _value(values, o + t[:, None] * d, nearest)
        for t in (middle - half / math.sqrt(3), middle + half / math.sqrt(3))
    ]
    return float((half * sum(found)).sum()) * float(np.linalg.norm(direction))


def emitted(column: Array, source: float = 1.0) -> float:
    """L = ∫ ε e^-τ along a column of unit length with a linear σ_t between its voxels' middles and one ε everywhere.

    Each piece is cut where its own τ, which is quadratic, grows by a fifth, and takes 8 Gauss points a cut; what lies
    behind 60 mean free paths does not count.
    """
    n = len(column)
    edges = np.concatenate([[0.0], (np.arange(n) + 0.5) / n, [1.0]])
    ends = np.concatenate([column[:1], column, column[-1:]]).astype(float)
    nodes, weights = _gauss(8)
    total = passed = 0.0
    for length, a, b in zip(np.diff(edges), ends[:-1], ends[1:], strict=True):
        slope, all_of_it = (b - a) / length, (a + b) / 2 * length
        levels = np.arange(0.2, min(all_of_it, 60.0), 0.2)
        places = 2 * levels / (a + np.sqrt(np.maximum(a * a + 2 * slope * levels, 0)))
        cuts = np.concatenate([[0.0], np.minimum(places, length), [length]])
        s = cuts[:-1, None] + np.diff(cuts)[:, None] * nodes
        inside = np.exp(-(passed + a * s + slope * s * s / 2))
        total += float((inside * weights * np.diff(cuts)[:, None]).sum())
        passed += all_of_it
    return source * total


def _between(values: Array, at: Array) -> Array:
    """Linear along the first axis; `at`: parts of it."""
    place = np.clip(at * len(values) - 0.5, 0, len(values) - 1)
    low = np.minimum(np.floor(place).astype(int), max(len(values) - 2, 0))
    part = (place - low).reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(values[low] * (1 - part) + values[np.minimum(low + 1, len(values) - 1)] * part)


def _pieces(cells: int) -> tuple[Array, Array]:
    """Gauss points, and their weights, of what is smooth between the middles of cells."""
    edges = np.concatenate([[0.0], (np.arange(cells) + 0.5) / cells, [1.0]])
    nodes, weights = _gauss(16)
    width = np.diff(edges)[:, None]
    return (edges[:-1, None] + width * nodes).reshape(-1), (width * weights).reshape(-1)


def _value(values: Array, points: Array, nearest: bool) -> Array:
    """(n,): at points (n, 3) in voxels."""
    size = np.array(values.shape[::-1])
    base = np.floor(points if nearest else points - 0.5)
    part = np.zeros_like(points) if nearest else points - 0.5 - base
    total = np.zeros(len(points))
    for corner in np.ndindex(2, 2, 2):
        x, y, z = np.clip(base + corner, 0, size - 1).astype(int).T
        total += np.where(np.array(corner) == 1, part, 1 - part).prod(axis=1) * values[z, y, x]
    return total


@cache
def _gauss(points: int) -> tuple[Array, Array]:
    """Gauss–Legendre on [0, 1]."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    return np.asarray((nodes + 1) / 2), np.asarray(weights / 2)
