"""Every lane width and every device computes the same picture: random numbers are addressed, not drawn in order."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from woodcock.device import WIDTHS, find
from woodcock.film import Film
from woodcock.probe import probe

TWO_DEVICES = """
import sys
import numpy as np
from woodcock.device import devices
from woodcock.render import Renderer
from woodcock.scene import parse

first, second = (Renderer(parse(sys.argv[1]), device).render(0, 32) for device in devices())
np.savez(sys.argv[2], first=first.mean, second=second.mean)
"""


@pytest.fixture
def cloud(box: dict[str, Any], grid: Callable[..., dict[str, Any]]) -> dict[str, Any]:
    """All that a path does: null collisions, scattering, shadow walks, roulette."""
    density = np.random.default_rng(1).random((11, 7, 9), dtype=np.float32)
    phase = {"kind": "henyey_greenstein", "g": 0.6}
    box["volumes"] = [grid(density, scale=12, albedo=[0.9, 0.6, 0.3], phase=phase)]
    box["lights"].append({"kind": "directional", "direction": [1, 0.3, 0.2], "irradiance": 4})
    return box


def same(a: np.ndarray, b: np.ndarray) -> bool:
    """The same paths but for the few on which float rounding turned a decision."""
    return float(np.mean(~np.isclose(a, b, rtol=1e-4))) < 0.02 and abs(a.mean() / b.mean() - 1) < 1e-3


def test_same_picture_at_every_width(cloud: dict[str, Any], picture: Callable[..., Film], lanes: int) -> None:
    one = picture(cloud, 32, 1)
    assert same(picture(cloud, 32, lanes).mean, one.mean)


def test_widths_are_probed() -> None:
    """The widths that tests run at are those that the device can run: one lane at least, all but the widest here."""
    widths = probe(find()).lanes
    assert 1 in widths
    assert set(widths) <= set(WIDTHS)


@pytest.mark.usefixtures("pocl")
def test_same_picture_on_two_devices(cloud: dict[str, Any], tmp_path: Path) -> None:
    """Two of PoCL's drivers, which it shows as two devices."""
    from tests.conftest import described

    out = tmp_path / "means.npz"
    command = [sys.executable, "-c", TWO_DEVICES, described(cloud).model_dump_json(), str(out)]
    subprocess.run(command, check=True, env={**os.environ, "POCL_DEVICES": "pthread basic"}, timeout=200)
    with np.load(out) as means:
        assert same(means["first"], means["second"])


def test_a_range_is_the_merge_of_its_parts(cloud: dict[str, Any], lanes: int) -> None:
    """[0, 64) = [0, 24) + [24, 64), to float64 rounding of the sums."""
    from tests.conftest import described

    from woodcock.render import Renderer

    renderer = Renderer(described(cloud), find(), lanes=lanes)
    whole, parts = renderer.render(0, 64), renderer.render(24, 64).merge(renderer.render(0, 24))
    assert parts.ranges == whole.ranges == ((0, 64),)
    assert np.array_equal(parts.count, whole.count)
    assert np.allclose(parts.mean, whole.mean, rtol=5e-14, atol=0)
    squares = whole.m2 + whole.mean**2 * whole.count[..., None]
    assert np.abs((parts.m2 - whole.m2) / squares).max() < 5e-14
