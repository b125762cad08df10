"""A majorant below σ_t is found while rendering, counted, and raised; the picture is right nevertheless."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.conftest import described
from tests.statistics import accept_z

from woodcock import render
from woodcock.device import Device
from woodcock.film import Film
from woodcock.layout import Layout, Read
from woodcock.plan import lay_out
from woodcock.repair import raised
from woodcock.scene import Scene

MAJORANTS: dict[str, dict[str, Any]] = {
    "small loop": {},
    "global": {"orders": 0},
    "small loop through cells": {"majorant": {"kind": "grid", "resolution": 3}},
    "grid": {"orders": 0, "majorant": {"kind": "grid", "resolution": 3}},
}


def too_low(factor: float) -> Callable[[Scene, Read], Layout]:
    """Lays out as ever, but for a majorant that is as much too low."""

    def lay_out_low(scene: Scene, read: Read) -> Layout:
        return raised(lay_out(scene, read), factor)

    return lay_out_low


@pytest.fixture
def uneven(box: dict[str, Any], grid: Callable[..., dict[str, Any]]) -> dict[str, Any]:
    """Absorbs along z by uneven layers, τ = 1.5, and nothing else."""
    layers = np.array([1, 0.1, 0.2, 1.7], np.float32).reshape(4, 1, 1)
    box["volumes"] = [grid(layers, scale=2, albedo=0)]
    return box


@pytest.mark.parametrize("name", MAJORANTS)
def test_a_majorant_too_low_is_raised(
    uneven: dict[str, Any], name: str, device: Device, monkeypatch: pytest.MonkeyPatch, lanes: int
) -> None:
    monkeypatch.setattr(render, "lay_out", too_low(0.3))
    renderer = render.Renderer(described(uneven | MAJORANTS[name]), device, lanes=lanes)
    film = renderer.render(0, 256)
    assert film.violations == 0
    assert film.faults.repaired > 0
    error = film.mean_luminance_error()
    accept_z((film.mean_luminance() - np.exp(-1.5)) / error)
    assert error < 0.002
    # The bound stays raised: what comes next has nothing to find.
    assert renderer.render(256, 512).faults.repaired == 0


@pytest.mark.parametrize("name", MAJORANTS)
def test_what_is_not_repaired_is_counted_with_its_weight(
    uneven: dict[str, Any], name: str, device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(render, "lay_out", too_low(0.3))
    monkeypatch.setattr(render, "MOST_ROUNDS", 0)
    film: Film = render.Renderer(described(uneven | MAJORANTS[name]), device).render(0, 64)
    assert film.faults.repaired == 0
    assert film.violations > 0
    # Nothing scatters, so that every path has its first throughput of 1 wherever it is violated.
    assert film.faults.touched == film.violations
    assert film.mean_luminance() > np.exp(-1.5) * 1.05  # the bias that the count tells of


def test_a_right_majorant_is_left_alone(uneven: dict[str, Any], picture: Callable[..., Film]) -> None:
    for keys in MAJORANTS.values():
        film = picture(uneven | keys, 64)
        assert (film.violations, film.faults.touched, film.faults.repaired) == (0, 0.0, 0)
