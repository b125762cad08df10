"""The isotropic half-space against Chandrasekhar's H function: R(μ0) = 1 - √(1-ω) H(μ0).

A sky of radiance 1 sends as much up at cosine μ0 as a beam at μ0 sends up in all (reciprocity). At ω = .2 most of what
is reflected has been through roulette.
"""

from __future__ import annotations

import pytest
from tests.analytic.scenes import Picture
from tests.analytic.slab_theory import HALF_SPACE, ISOTROPIC, Slab
from tests.analytic.slabs import SKY, TIGHT, leaving, medium, reproduces, upwelling

#: What comes back from the bottom is 1e-9 of the flux at ω = .99.
DEEP = 60


@pytest.mark.parametrize(("omega", "mu"), [(omega, mu) for omega, (row, _) in HALF_SPACE.items() for mu in row])
def test_plane_albedo(omega: float, mu: float, picture: Picture) -> None:
    slab = Slab(DEEP, omega, ISOTROPIC)
    scene = {"volumes": [medium(slab)], "lights": [SKY]}
    reproduces(picture, f"ω = {omega}, R({mu})", scene, leaving(slab, mu), HALF_SPACE[omega][0][mu], TIGHT)


@pytest.mark.parametrize("omega", HALF_SPACE)
def test_diffuse_albedo(omega: float, picture: Picture) -> None:
    slab = Slab(DEEP, omega, ISOTROPIC)
    scene = {"volumes": [medium(slab)], "lights": [SKY]}
    reproduces(picture, f"ω = {omega}, R", scene, upwelling(slab), HALF_SPACE[omega][1], TIGHT)
