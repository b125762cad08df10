"""The plane slabs of which values are published: fluxes, by cosine-weighted averages over directions, and radiances.

What is expected is what 64 streams make of them; `test_disort.py` holds the published digits to that.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.special import expn
from tests.analytic.scenes import Grid, Picture, Scene
from tests.analytic.slab_theory import HEASLET_WARMING, ISOTROPIC, RADIANCES, SLABS, Slab, fluxes, radiance
from tests.analytic.slabs import (
    COARSE,
    SKY,
    TIGHT,
    beam,
    black_floor,
    black_roof,
    diffuse,
    downwelling,
    layered,
    leaving,
    measured,
    medium,
    reproduces,
    upwelling,
)

BEAMS = {name: slab for name, slab in SLABS.items() if slab.mu0 is not None}
#: Deep ones take long to know well by the flux that leaves; turned round they are cheap (`test_turned_round`).
DEEP = ("DISORT 1e", "thick")
DIFFUSE = {f"τ = {tau}": Slab(tau, 1, ISOTROPIC, None, 1 - t, t) for tau, t in HEASLET_WARMING.items()}
DIFFUSE |= {name: slab for name, slab in SLABS.items() if slab.mu0 is None}


def slow(*values: Any) -> Any:
    return pytest.param(*values, marks=[pytest.mark.slow, pytest.mark.timeout(3600)])


def under_a_beam(slab: Slab) -> Scene:
    assert slab.mu0 is not None
    return {"volumes": [medium(slab)], "lights": beam(slab.mu0)}


@pytest.mark.parametrize(
    ("name", "bias"),
    [
        *((name, TIGHT) for name in BEAMS if name not in DEEP),
        *((name, COARSE) for name in DEEP),
        *(slow(name, TIGHT) for name in DEEP),
    ],
)
def test_reflected_beam(name: str, bias: float, picture: Picture) -> None:
    slab = SLABS[name]
    reproduces(picture, f"{name}, R", under_a_beam(slab), upwelling(slab), fluxes(slab)[0], bias)


@pytest.mark.parametrize(
    ("name", "bias"), [*((name, TIGHT) for name in BEAMS if name not in DEEP), *(slow(name, COARSE) for name in DEEP)]
)
def test_transmitted_beam(name: str, bias: float, picture: Picture) -> None:
    """What is scattered of it."""
    slab = SLABS[name]
    reproduces(picture, f"{name}, T", under_a_beam(slab), downwelling(slab), fluxes(slab)[1], bias)


@pytest.mark.parametrize(
    ("name", "reflected"), [("DISORT 3a", False), ("DISORT 2b", True)], ids=["delta and ratio tracking", "clocks"]
)
def test_uneven_density(name: str, reflected: bool, picture: Picture, grid: Grid) -> None:
    """One is rendered by the small loop, the other, for its phase function, by the full one."""
    slab = SLABS[name]
    scene = under_a_beam(slab) | {"volumes": [layered(slab, grid)]}
    view, expected = (upwelling(slab), fluxes(slab)[0]) if reflected else (downwelling(slab), fluxes(slab)[1])
    reproduces(picture, f"{name}, uneven", scene, view, expected, TIGHT)


@pytest.mark.parametrize("bias", [COARSE, slow(TIGHT)])
def test_three_slabs_in_colour(bias: float, picture: Picture) -> None:
    """Red absorbs as DISORT 1a, green does not as 1b, blue is 1024 times denser as 1e: one picture of all."""
    thin = SLABS["DISORT 1a"]
    three = [SLABS[name] for name in ("DISORT 1a", "DISORT 1b", "DISORT 1e")]
    coloured = medium(thin, sigma_t=[slab.tau / thin.tau for slab in three], albedo=[slab.omega for slab in three])
    scene = under_a_beam(thin) | {"volumes": [coloured]}
    reproduces(picture, "three, R", scene, upwelling(thin), [fluxes(slab)[0] for slab in three], bias)


@pytest.mark.parametrize("name", BEAMS)
@pytest.mark.parametrize("as_grid", [False, True], ids=["constant", "grid"])
def test_unscattered_beam(name: str, as_grid: bool, picture: Picture, grid: Grid) -> None:
    """Without random numbers: the sky's light through the slab, along the beam. Below float32's range it is 0."""
    slab = SLABS[name]
    assert slab.mu0 is not None
    view = leaving(slab, slab.mu0)
    volume = layered(slab, grid) if as_grid else medium(slab)
    scene = {"volumes": [volume], "lights": [SKY], "integrator": {"kind": "transmittance"}, **view.keys}
    film = picture(scene, 4)
    assert film.mean == pytest.approx(np.exp(-slab.tau / slab.mu0), rel=1e-5, abs=1.2e-38)
    assert film.mean == pytest.approx(slab.beam, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "reflected", "bias"),
    [
        *((name, True, TIGHT) for name in DEEP),
        *((name, False, COARSE) for name in DEEP),
        *(slow(name, False, TIGHT) for name in DEEP),
    ],
)
def test_turned_round(name: str, reflected: bool, bias: float, picture: Picture) -> None:
    """By reciprocity R and T of a beam are the radiance along it that leaves under a sky on one side only."""
    slab = SLABS[name]
    assert slab.mu0 is not None
    black = black_floor(slab) if reflected else black_roof(slab)
    scene = {"volumes": [medium(slab)], "surfaces": black, "lights": [SKY]}
    expected = fluxes(slab)[0 if reflected else 1]
    what = f"{name}, {'R' if reflected else 'T'} turned round"
    reproduces(picture, what, scene, leaving(slab, slab.mu0), expected, bias)


@pytest.mark.parametrize("name", ["DISORT 1c", "DISORT 1f"])
def test_reflected_diffuse_light(name: str, picture: Picture) -> None:
    slab = SLABS[name]
    scene = {"volumes": [medium(slab)], "lights": diffuse()}
    reproduces(picture, f"{name}, R", scene, upwelling(slab), fluxes(slab)[0], TIGHT)


@pytest.mark.parametrize(
    ("name", "bias"),
    [
        *((name, COARSE if DIFFUSE[name].tau > 5 else TIGHT) for name in DIFFUSE),
        *(slow(name, TIGHT) for name in DIFFUSE if DIFFUSE[name].tau > 5),
    ],
)
def test_transmitted_diffuse_light(name: str, bias: float, picture: Picture) -> None:
    """What gets through without scattering is rendered without random numbers, and is 2 E₃(τ)."""
    slab = DIFFUSE[name]
    view, volumes = downwelling(slab), [medium(slab)]
    sky = {"volumes": volumes, "lights": [SKY], "integrator": {"kind": "transmittance"}, **view.keys}
    direct = float(measured(picture(sky, 16), view)[0][0])
    assert direct == pytest.approx(2 * expn(3, slab.tau), rel=1e-4)
    scene = {"volumes": volumes, "lights": diffuse()}
    reproduces(picture, f"{name}, T", scene, view, fluxes(slab)[1], bias, besides=direct)


@pytest.mark.parametrize(("name", "mu"), [(name, mu) for name, row in RADIANCES.items() for mu in row])
def test_radiance_leaving_upwards(name: str, mu: float, picture: Picture) -> None:
    slab = SLABS[name]
    lit = {"lights": [SKY], "surfaces": black_floor(slab)} if slab.mu0 is None else {"lights": beam(slab.mu0)}
    scene = {"volumes": [medium(slab)], **lit}
    reproduces(picture, f"{name}, μ = {mu}", scene, leaving(slab, mu), radiance(slab, mu), TIGHT)
