"""Ranges of samples on a device, of any length."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.conftest import described

from woodcock import render
from woodcock.device import Device
from woodcock.render import Renderer


@pytest.mark.parametrize("stop", [19, 20, 28])
def test_a_range_of_many_launches_is_that_range(
    box: dict[str, Any], device: Device, monkeypatch: pytest.MonkeyPatch, stop: int
) -> None:
    """Launches of 8 samples at most, the last of 1 to 8, hold what a single one does."""
    renderer = Renderer(described(box), device)
    whole = renderer.render(3, stop)
    monkeypatch.setattr(render, "LARGEST_LAUNCH", 8)
    parts = renderer.render(3, stop)
    assert parts.ranges == whole.ranges == ((3, stop),)
    assert np.array_equal(parts.count, np.full((32, 32), stop - 3))
    assert np.allclose(parts.mean, whole.mean, rtol=1e-13, atol=0)
    assert np.allclose(parts.m2, whole.m2, rtol=1e-10, atol=1e-12)
