"""Plane slabs as scenes, and what is measured of them: fluxes and radiances, known as well as a test asks for.

σ_t = 1 on the whole of the height, so that a slab is as deep as τ says; it lies under z = 0.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np
from numpy.typing import NDArray
from scipy.special import roots_jacobi
from scipy.stats import norm
from tests.analytic.scenes import Grid, Kind, Picture, Scene, is_clean
from tests.analytic.slab_theory import Slab
from tests.statistics import SIGNIFICANCE, accept_z

from woodcock.film import Film

Array = NDArray[np.float64]

#: A slab's half width over its depth: light that leaves by a side has come 60 mean free paths at the least.
WIDE = 2000
#: Of all pictures of every direction. Rows are so narrow that a radiance hardly changes over one with its cosine: 3e-6.
ROWS, COLUMNS = 512, 16
#: Samples of a picture that only finds out how many are needed, and how many times as many are taken: its error, too,
#: is estimated.
PILOT, MARGIN = 32, 1.3
#: A comparison refuses what lies off by more standard errors.
LIMIT = float(norm.isf(SIGNIFICANCE / 2))
#: What comparisons would find wrong. Coarse ones of what takes long have a tight one beside them among the slow tests.
TIGHT, COARSE = 0.005, 0.03

SKY: Kind = {"kind": "constant", "radiance": 1}


def medium(slab: Slab, **keys: Any) -> Kind:
    width = WIDE * slab.tau
    shape = {"kind": "box", "min": [-width, -width, -slab.tau], "max": [width, width, 0]}
    return {"kind": "constant", "shape": shape, "sigma_t": 1, "albedo": slab.omega, "phase": slab.phase, **keys}


def layered(slab: Slab, grid: Grid) -> Kind:
    """The same slab, its density uneven in height: fluxes know the optical depth alone."""
    density = np.random.default_rng(5).random((7, 1, 1), dtype=np.float32)
    width = 2 * WIDE * slab.tau
    placed = [[width, 0, 0, -width / 2], [0, width, 0, -width / 2], [0, 0, slab.tau, -slab.tau], [0, 0, 0, 1]]
    scale = float(1 / density.mean(dtype=np.float64))
    return grid(density, scale=scale, to_world=placed, albedo=slab.omega, phase=slab.phase)


def beam(mu: float) -> list[Kind]:
    """From above at cosine mu, its flux π: as that of light of radiance 1."""
    return [{"kind": "directional", "direction": [-math.sqrt(1 - mu * mu), 0, -mu], "irradiance": math.pi / mu}]


def diffuse() -> list[Kind]:
    """Light of radiance 1 from above as a quadrature of 16 beams (Gauss-Jacobi, weight μ): their flux π.

    Isotropic slabs do not mind that all of them come from one side. R of a slab of τ = 1/32 is off by 5e-5 of it, of
    deeper ones by 1e-6.
    """
    x, weights = roots_jacobi(16, 0, 1)
    shares = weights / weights.sum()
    return [
        light | {"irradiance": share * light["irradiance"]}
        for mu, share in zip((1 + x) / 2, shares, strict=True)
        for light in beam(float(mu))
    ]


def black_floor(slab: Slab) -> list[Kind]:
    """Nothing shines on the slab from below."""
    return [_black(slab, -1.01)]


def black_roof(slab: Slab) -> list[Kind]:
    """Nothing shines on the slab from above. Cameras are closer."""
    return [_black(slab, 0.01)]


def _black(slab: Slab, z: float) -> Kind:
    width = 2 * WIDE * slab.tau
    placed = [[width, 0, 0, 0], [0, width, 0, 0], [0, 0, 1, z * slab.tau], [0, 0, 0, 1]]
    return {"kind": "rectangle", "to_world": placed, "material": {"kind": "diffuse", "reflectance": 0}}


class View(NamedTuple):
    """A camera with its film, and weights (height, width, 1) of its pixels that add up to 1."""

    keys: dict[str, Any]
    weights: Array


def upwelling(slab: Slab) -> View:
    """Flux that leaves upwards, over π."""
    return _directions(0.001 * slab.tau, np.arange(ROWS) >= ROWS // 2)


def downwelling(slab: Slab) -> View:
    """Flux that leaves downwards, over π."""
    return _directions(-1.001 * slab.tau, np.arange(ROWS) < ROWS // 2)


def _directions(z: float, seen: NDArray[np.bool_]) -> View:
    """Every direction, by its pixel's ∫ |cos θ| dω / π."""
    camera = {"kind": "spherical", "origin": [0, 0, z], "target": [1, 0, z], "up": [0, 0, 1]}
    edges = np.sin(np.pi * np.arange(ROWS + 1) / ROWS) ** 2
    weights = np.where(seen, np.abs(np.diff(edges)), 0) / COLUMNS
    film = {"width": COLUMNS, "height": ROWS}
    return View({"camera": camera, "film": film}, np.broadcast_to(weights[:, None, None], (ROWS, COLUMNS, 1)))


def leaving(slab: Slab, mu: float) -> View:
    """Radiance that leaves upwards at cosine mu."""
    distance = 0.001 * slab.tau
    camera = {
        "kind": "orthographic",
        "origin": [distance * math.sqrt(1 - mu * mu), 0, distance * mu],
        "target": [0, 0, 0],
        "up": [0, 1, 0],
        "height": 1e-5 * slab.tau,
    }
    size = 64
    return View({"camera": camera, "film": {"width": size, "height": size}}, np.full((size, size, 1), size**-2.0))


def reproduces(
    picture: Picture, what: str, scene: Scene, view: View, expected: Any, bias: float, besides: float = 0
) -> None:
    """Asserts that what is seen is as expected, and that it would have been refused had it been off by `bias` of it.

    expected: a number, or one a channel; besides: the part of it that is not seen, for it is known without noise.
    """
    scene = {"integrator": {"kind": "volumetric_path"}} | scene | view.keys
    expected = np.atleast_1d(expected)
    # A bias of two standard errors more than are allowed is refused 98 times in 100.
    bound = bias * expected / (LIMIT + 2)
    _, error = measured(picture(scene | {"seed": crc32(f"{what}, pilot".encode())}, PILOT), view)
    samples = math.ceil(PILOT * max(1, MARGIN * float(np.max(error / bound)) ** 2))
    film = picture(scene | {"seed": crc32(what.encode())}, samples)
    value, error = measured(film, view)
    assert is_clean(film)
    assert np.all(error <= bound), f"{what}: known to {np.max(error / expected):.2g} only"
    # Channels share their paths.
    accept_z((value + besides - expected) / error, what, exact=value.size == 1)


def measured(film: Film, view: View) -> tuple[Array, Array]:
    """The weighted mean of its pixels, by channel, and its standard error."""
    value = (view.weights * film.mean).sum(axis=(0, 1))
    return value, np.sqrt((view.weights**2 * film.variance()).sum(axis=(0, 1)))
