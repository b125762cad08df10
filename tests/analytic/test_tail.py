"""What one number in ten million decides: the bits of a word that begins with many zeros go on with those of another.

No mean of a picture tells whether they do. So single samples are rendered whose words in the flight's first step are
known, by the published hash, to be such; what they decide is computed from them in float64.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from tests.analytic.scenes import Grid, Scene, constant, cuboid, random_walk
from tests.conftest import described
from tests.kernels.test_rng import pcg4d

from woodcock.device import Device
from woodcock.integrator import volumetric_path
from woodcock.render import Renderer

SEED = 7
#: Pixel (of 32 × 32) and sample whose first word begins with 23 zeros, or with as many ones; whose last, with 25 zeros.
FAR, SHORT, SCARCE = (452, 12671), (288, 6547), (620, 225)
#: Relative: on either side of what the words say, by more than float32 rounds and less than the further bits are worth.
CLOSE = 1e-5

One = Callable[[Scene, tuple[int, int]], float]


def uniform(address: tuple[int, int], word: int, *, flipped: bool = False) -> float:
    """Of the first step after the camera's, with the bits that go on."""

    def words(dimension: int) -> int:
        hashed = pcg4d(np.array([[*address, SEED, dimension]], np.uint32).T)[:, 0]
        return int((hashed ^ (hashed >> np.uint32(16)))[word])

    first = words(1) ^ (0xFFFFFFFF if flipped else 0)
    assert first >> 9 == 0
    return ((first >> 1) + ((words(~np.uint32(2)) >> 1) + 0.5) * 2.0**-31) * 2.0**-31


@pytest.fixture(params=["simple", "full"])
def one(request: pytest.FixtureRequest, device: Device, monkeypatch: pytest.MonkeyPatch) -> One:
    """Renders one sample of one pixel, by either loop."""
    if request.param == "full":
        monkeypatch.setattr(volumetric_path, "suits", lambda *_: False)

    def render(scene: Scene, address: tuple[int, int]) -> float:
        pixel, sample = address
        film = Renderer(described(random_walk(scene, seed=SEED)), device).render(sample, sample + 1)
        return float(film.mean.reshape(-1)[pixel])

    return render


@pytest.mark.parametrize("medium", ["constant", "grid"])
def test_flights_go_as_far_as_their_words_say(box: Scene, grid: Grid, one: One, medium: str) -> None:
    """A black medium a little thinner than the flight is long lets it through; a little thicker, it does not."""
    far, short = -np.log(uniform(FAR, 0)), -np.log1p(-uniform(SHORT, 0, flipped=True))
    for address, length in ((FAR, far), (SHORT, short)):
        for tau, expected in ((length * (1 - CLOSE), 1), (length * (1 + CLOSE), 0)):
            ones = grid(np.ones((2, 2, 2), np.uint8), scale=tau, albedo=0)
            box["volumes"] = [constant(cuboid(), tau, 0) if medium == "constant" else ones]
            assert one(box, address) == expected


def test_collisions_are_as_scarce_as_their_words_say(box: Scene, grid: Grid, one: One) -> None:
    """Under a majorant that is far too high for this ray, one tentative collision of many might be real."""
    share = uniform(SCARCE, 3)
    for density, expected in ((share * (1 - CLOSE), 1), (share * (1 + CLOSE), 0)):
        values = np.full((1, 1, 8), density, np.float32)
        values[..., 0] = 1  # beside the ray
        box |= {"volumes": [grid(values, scale=20, albedo=0)], "majorant": {"kind": "global"}}
        assert one(box, SCARCE) == expected
