"""Layers of what camera rays meet first, against what geometry and Beer–Lambert say."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.statistics import accept_z

from woodcock.film import Film

Box = dict[str, Any]
Picture = Callable[..., Film]

LAYERS = ["albedo", "normal", "depth", "optical_depth", "transmittance", "position"]
#: A wall across the picture at z = 4, facing the camera at z = -1.
WALL = {
    "kind": "rectangle",
    "to_world": [[9, 0, 0, 0], [0, -9, 0, 0], [0, 0, -1, 4], [0, 0, 0, 1]],
    "material": {"kind": "diffuse", "reflectance": 0.25},
}


def mean(film: Film, layer: str) -> Any:
    return film.layer(layer).mean.mean(axis=(0, 1))


def meets(film: Film, layer: str, expected: float, channel: int = 0, exact: bool = True) -> None:
    """One channel of a layer has this mean, within its noise, which is below 1 %."""
    part = film.layer(layer)
    error = np.sqrt(part.variance()[..., channel].mean() / part.count.size)
    assert error < 0.01 * abs(expected)
    accept_z((part.mean[..., channel].mean() - expected) / error, layer, exact=exact)


def test_a_wall(box: Box, picture: Picture) -> None:
    film = picture(box | {"volumes": [], "surfaces": [WALL], "layers": LAYERS, "lights": []}, 16)
    assert mean(film, "albedo") == pytest.approx(0.25, rel=1e-5)
    assert mean(film, "normal") == pytest.approx([0, 0, -1], abs=1e-6)
    assert mean(film, "depth") == pytest.approx(5, rel=1e-6)
    assert mean(film, "position")[2] == pytest.approx(4, rel=1e-6)
    meets(film, "position", 0.5, 0)
    meets(film, "position", 0.5, 1)
    assert mean(film, "optical_depth") == 0
    assert mean(film, "transmittance") == 0  # nothing comes through a wall


@pytest.mark.parametrize("as_grid", [False, True])
def test_a_medium(box: Box, grid: Callable[..., Any], picture: Picture, as_grid: bool) -> None:
    """σ_t = 2 in the unit cube, albedo 0.5: first collisions follow 2 exp(-2 z)."""
    if as_grid:
        box["volumes"] = [grid(np.ones((2, 3, 4), np.uint8), scale=2, albedo=0.5)]
    film = picture(box | {"layers": LAYERS}, 4096)
    through = np.exp(-2.0)
    if as_grid:
        meets(film, "transmittance", through, exact=False)
        meets(film, "optical_depth", 2, exact=False)
    else:
        assert mean(film, "transmittance") == pytest.approx(through, abs=1e-6)
        assert mean(film, "optical_depth") == pytest.approx(2, rel=1e-6)
    # Of one first collision: the others are not independent of its depth.
    depth = (1 - 3 * through) / 2  # ∫ z 2 exp(-2 z) dz over the cube
    meets(film, "depth", depth + (1 - through))  # the camera is 1 away
    meets(film, "position", depth, 2, exact=False)
    meets(film, "albedo", 0.5 * (1 - through), exact=False)
    assert mean(film, "normal") == pytest.approx([0, 0, 0], abs=0)


def test_a_wall_behind_a_medium_and_glass(box: Box, picture: Picture) -> None:
    """Depth is that of the wall where the ray gets there; index-matched surfaces are not met."""
    box["volumes"][0] |= {"sigma_t": 1, "albedo": 0}
    pane = WALL | {"to_world": [[9, 0, 0, 0], [0, 9, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]], "material": {"kind": "null"}}
    film = picture(box | {"surfaces": [pane, WALL], "layers": LAYERS}, 4096)
    through = np.exp(-1.0)
    assert mean(film, "optical_depth") == pytest.approx(1, rel=1e-5)
    inside = 1 - 2 * through  # ∫ z exp(-z) dz over the cube
    meets(film, "depth", 5 * through + inside + (1 - through))
    meets(film, "normal", -through, 2, exact=False)
    meets(film, "albedo", 0.25 * through, exact=False)


def test_positions_are_in_the_scene_s_own_units(box: Box, picture: Picture) -> None:
    """However large or far from the origin the scene is."""
    at, size = np.array([1e4, -2e4, 3e4]), 1e3
    box["camera"] |= {
        "origin": (at - np.array([0, 0, size])).tolist(), "target": at.tolist(), "height": size,
    }  # fmt: skip
    wall = WALL | {
        "to_world": [[size, 0, 0, at[0]], [0, -size, 0, at[1]], [0, 0, -1, at[2]], [0, 0, 0, 1]],
    }
    film = picture(box | {"volumes": [], "surfaces": [wall], "layers": ["position", "depth"]}, 16)
    assert mean(film, "depth") == pytest.approx(size, rel=1e-5)
    assert mean(film, "position") == pytest.approx(at, rel=2e-3)
