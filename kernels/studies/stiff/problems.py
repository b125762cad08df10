"""Rays from the eye at s = 0 to s = 1 with σ_t and q along them, and the scenes in which a camera looks along one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad

Array = NDArray[np.float64]
Kind = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Problem:
    """σ_t and q are polynomials of first degree between `edges`, given by their values at both ends of each piece.

    edges: (n + 1,), from 0 to 1; sigma, q: (n, 2); behind: L at s = 1; volumes: (folder) -> the scene's media.
    """

    name: str
    edges: Array
    sigma: Array
    q: Array
    volumes: Callable[[Path], list[Kind]]
    behind: float = 0.0
    scene: Kind = field(default_factory=dict)

    def at(self, s: Array, pieces: NDArray[np.intp] | None = None) -> tuple[Array, Array]:
        """σ_t and q at s; at a jump those behind it, unless `pieces` says which piece is meant."""
        if pieces is None:
            pieces = np.clip(np.searchsorted(self.edges, s, side="right") - 1, 0, len(self.sigma) - 1)
        u = (s - self.edges[pieces]) / (self.edges[pieces + 1] - self.edges[pieces])
        sigma, q = self.sigma[pieces], self.q[pieces]
        return sigma[:, 0] + u * (sigma[:, 1] - sigma[:, 0]), q[:, 0] + u * (q[:, 1] - q[:, 0])

    @property
    def layered(self) -> bool:
        """Are σ_t and q constant in every piece?"""
        return bool(np.all(self.sigma[:, 0] == self.sigma[:, 1]) and np.all(self.q[:, 0] == self.q[:, 1]))

    def exact(self) -> float:
        """L(0): of layers in closed form, elsewhere ∫ q exp(-τ) by adaptive quadrature with τ in closed form."""
        radiance = self.behind
        for (near, far), sigma, q in reversed(list(zip(pairwise(self.edges), self.sigma, self.q, strict=True))):
            length, z = far - near, (far - near) * sigma.mean()
            if sigma[0] == sigma[1] and q[0] == q[1]:
                gain = -q[0] * length * np.expm1(-z) / z if z > 0 else q[0] * length
            else:

                def integrand(s: float, length: float = length, sigma: Array = sigma, q: Array = q) -> float:
                    u = s / length
                    slopes = u * (q[1] - q[0]), u * (sigma[1] - sigma[0])
                    return float((q[0] + slopes[0]) * np.exp(-s * (sigma[0] + slopes[1] / 2)))

                # To where nothing is seen any more, in parts that quadrature cannot overlook.
                parts = np.unique(np.clip(np.array([0, 0.1, 1, 3, 10, 50]) / sigma.max(), 0, length))
                parts = np.append(parts, length) if parts[-1] < length else parts
                gain = sum(quad(integrand, a, b, epsabs=1e-14, epsrel=1e-12, limit=500)[0] for a, b in pairwise(parts))
            radiance = radiance * np.exp(-z) + gain
        return float(radiance)


def layers(name: str, edges: Any, sigma: Any, q: Any, volumes: Callable[[Path], list[Kind]], **keys: Any) -> Problem:
    """sigma, q: one number a piece."""
    return Problem(
        name, np.array(edges, float), np.repeat(np.c_[sigma], 2, 1), np.repeat(np.c_[q], 2, 1), volumes, **keys
    )


def grid(folder: Path, sigma: Any, q: Any, interpolation: str = "nearest") -> Kind:
    """A column of voxels along z in the unit cube."""
    files = [folder / f"{len(list(folder.iterdir())) + k}.npy" for k in (0, 1)]
    for file, values in zip(files, (sigma, q), strict=True):
        np.save(file, np.asarray(values, np.float32).reshape(-1, 1, 1))
    emission = {"kind": "grid", "file": str(files[1])}
    medium = {"kind": "grid", "file": str(files[0]), "albedo": 0, "interpolation": interpolation}
    return medium | ({"emission": emission} if np.any(q) else {})


def slab(near: float, far: float, sigma_t: float, epsilon: float) -> Kind:
    shape = {"kind": "box", "min": [0, 0, near], "max": [1, 1, far]}
    emission = {"kind": "constant", "epsilon": epsilon}
    return {"kind": "constant", "shape": shape, "sigma_t": sigma_t, "albedo": 0, "emission": emission}


def constant(sigma: float, source: float = 1.0) -> Problem:
    """σ_t and q = σ_t B: L = B (1 - exp(-σ_t))."""
    sigma = float(np.float32(sigma))
    q = float(np.float32(sigma * source))
    return layers("constant", [0, 1], [sigma], [q], lambda folder: [grid(folder, [sigma], [q])])


def transparent(sigma: float) -> Problem:
    """q = 1 whatever σ_t: L tends to 1 as σ_t goes to 0."""
    return layers("transparent", [0, 1], [sigma], [1.0], lambda folder: [slab(0, 1, sigma, 1.0)])


#: ε of eight layers, the even ones clear and the odd ones opaque; source functions are ε / σ_t there.
GLOW = (1.0, 0.5, 2.0, 3.0, 0.5, 0.25, 1.0, 2.0)


def jumps(high: float = 1e8, *, boxes: bool = False) -> Problem:
    """Eight layers, σ_t = 1e-3 and `high` in turn; each glows in its own way. boxes: homogeneous media, not voxels."""
    sigma = [high if k % 2 else 1e-3 for k in range(8)]
    sigma = np.asarray(sigma, np.float32).astype(float).tolist()
    q = [glow * (high if k % 2 else 1.0) for k, glow in enumerate(GLOW)]
    edges = np.arange(9) / 8
    if boxes:
        media = [slab(*numbers) for numbers in zip(edges[:-1].tolist(), edges[1:].tolist(), sigma, q, strict=True)]
        return layers("jumps", edges, sigma, q, lambda folder: media)
    return layers("jumps", edges, sigma, q, lambda folder: [grid(folder, sigma, q)])


def foils(width: float = 2.0**-27) -> Problem:
    """Seven foils of optical depth ½ in the clear, each with a source function of its own, and light behind them."""
    near = np.arange(1, 8) / 8
    sigma = 0.5 / width
    sources = [1.0, 4.0, 0.5, 2.0, 8.0, 0.25, 3.0]
    edges = np.unique([0, 1, *near, *(near + width)])
    inside = np.arange(len(edges) - 1) % 2 == 1
    q = np.where(inside, 0, 0.0)
    q[inside] = sigma * np.array(sources)
    media = [slab(a, a + width, sigma, sigma * source) for a, source in zip(near.tolist(), sources, strict=True)]
    light = {"lights": [{"kind": "constant", "radiance": 0.5}]}
    return layers("foils", edges, np.where(inside, sigma, 0), q, lambda folder: media, behind=0.5, scene=light)


def ramp() -> Problem:
    """σ_t from 1 to 1e8, ten times from voxel to voxel and linear between, as is ε; q / σ_t falls."""
    sigma, middles = 10.0 ** np.arange(9), (np.arange(9) + 0.5) / 9
    q = sigma * np.asarray(2.0 - np.arange(9) / 8, np.float32)
    edges = np.array([0, *middles, 1])
    ends = [np.c_[v[[0, *range(9)]], v[[*range(9), 8]]] for v in (sigma, q)]
    return Problem("ramp", edges, *ends, lambda folder: [grid(folder, sigma, q, "trilinear")])
