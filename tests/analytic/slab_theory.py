"""Plane slabs of which published values are known, and the discrete-ordinates solution of any (PythonicDISORT)."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PythonicDISORT import pydisort
from PythonicDISORT.subroutines import interpolate
from tests.analytic.scenes import Kind

STREAMS = 64
#: Phase functions have more moments than streams: the peak beyond counts as unscattered (delta-M).
MOMENTS = 400
#: What of 1 a slab without absorption, τ deep, absorbs over its depth: at 1 the solution is singular, and closer to it
#: rounding takes over. Leaves 4e-5 of a flux at most.
LOST = 1e-6

ISOTROPIC: Kind = {"kind": "isotropic"}
RAYLEIGH: Kind = {"kind": "rayleigh"}


def forward(g: float) -> Kind:
    return {"kind": "henyey_greenstein", "g": g}


class Slab(NamedTuple):
    """τ, ω, phase function, cosine of the incident beam (none: diffuse light), and what is published of it:

    reflected and transmitted flux over the incident one, unscattered light apart only where it is a beam.
    """

    tau: float
    omega: float
    phase: Kind
    mu0: float | None = None
    reflected: float = 0
    transmitted: float = 0
    beam: float = 0


#: MCML: Wang & Jacques (1992), table 6.1. DISORT: the test set of Stamnes et al. (1988), as it names them.
#: Thick: van de Hulst (1980). 1a, 1b, 1c, 2a and 2b are what 16 streams make of slabs so thin: `test_disort.py`.
SLABS = {
    "MCML 6.1": Slab(2, 0.9, forward(0.75), 1, 0.097395, 0.525622, 0.135335),
    "DISORT 1a": Slab(0.03125, 0.2, ISOTROPIC, 0.1, 0.025447, 0.025277, 0.731616),
    "DISORT 1b": Slab(0.03125, 1, ISOTROPIC, 0.1, 0.134620, 0.133764, 0.731616),
    "DISORT 1c": Slab(0.03125, 0.99, ISOTROPIC, None, 0.028857, 0.970517),
    "DISORT 1e": Slab(32, 1, ISOTROPIC, 0.1, 0.978453, 0.021548, 0),
    "DISORT 1f": Slab(32, 0.99, ISOTROPIC, None, 0.794559, 0.001464),
    "DISORT 2a": Slab(0.2, 0.5, RAYLEIGH, 0.080442, 0.211725, 0.174817, 0.083220),
    "DISORT 2b": Slab(0.2, 1, RAYLEIGH, 0.080442, 0.496846, 0.419930, 0.083220),
    "DISORT 3a": Slab(1, 1, forward(0.75), 1, 0.078742, 0.553379, 0.367880),
    "thick": Slab(100, 1, forward(0.85), 1, 0.896810, 0.103190, 0),
}
#: Radiance that leaves upwards at cosine μ where the incident flux is π. 3a is what 16 streams make of its lobe.
RADIANCES = {
    "DISORT 1f": {0.1: 0.877510, 0.5: 0.815136, 1: 0.752715},
    "DISORT 3a": {0.1: 0.151159, 0.5: 0.101103, 1: 0.0395460},
}
#: T of conservative isotropic slabs under diffuse light, by τ: Heaslet & Warming (1965).
HEASLET_WARMING = {0.1: 0.9157, 0.5: 0.7040, 1: 0.5534, 2: 0.3901, 10: 0.1167}
#: Of a half-space, by ω: R(μ0) = 1 - √(1-ω) H(μ0), and R of diffuse light (Chandrasekhar 1960).
HALF_SPACE = {
    0.2: ({0.1: 0.082660, 0.5: 0.050855, 1: 0.035231}, 0.046265),
    0.5: ({0.1: 0.241721, 0.5: 0.160144, 1: 0.115226}, 0.146544),
    0.9: ({0.1: 0.629336, 0.5: 0.507939, 1: 0.414947}, 0.478024),
    0.99: ({0.1: 0.877512, 0.5: 0.815140, 1: 0.752721}, 0.794564),
}


def fluxes(slab: Slab, streams: int = STREAMS) -> tuple[float, float]:
    """R and T, of a beam without what is not scattered, of diffuse light with it."""
    _, up, down, _ = _solved(slab, streams)
    return float(up(0)), float(down(slab.tau)[0])


def radiance(slab: Slab, mu: float, streams: int = STREAMS) -> float:
    """Leaving upwards at cosine mu where the incident flux is π; of slabs lit alike from all around."""
    assert slab.mu0 in (None, 1)
    *_, azimuthal_mean = _solved(slab, streams)
    return float(np.pi * interpolate(azimuthal_mean)(mu, 0))


def _solved(slab: Slab, streams: int) -> tuple[Callable[..., Any], ...]:
    moments = _moments(slab.phase)
    light = {"I0": 0, "b_neg": 1 / np.pi} if slab.mu0 is None else {"I0": 1 / slab.mu0, "b_neg": 0}
    omega = min(slab.omega, 1 - LOST / max(slab.tau, 1))
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Some delta-scaled single-scattering albedos are very close to 1")
        solution = pydisort(
            np.array([slab.tau]),
            np.array([omega]),
            streams,
            moments[None],
            mu0=slab.mu0 or 0,
            phi0=0,
            NLeg=streams,
            f_arr=moments[[streams]],
            only_flux=True,
            **light,
        )
    return tuple(solution)


def _moments(phase: Kind) -> NDArray[np.float64]:
    """Means of the Legendre polynomials of cos θ."""
    moments = np.zeros(MOMENTS)
    match phase["kind"]:
        case "isotropic":
            moments[0] = 1
        case "rayleigh":
            moments[[0, 2]] = 1, 0.1
        case "henyey_greenstein":
            moments = phase["g"] ** np.arange(MOMENTS)
    return moments
