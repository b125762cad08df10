"""Layers of what camera rays meet first, against what geometry and Beer–Lambert say."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

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


def test_a_wall(box: Box, picture: Picture) -> None:
    film = picture(box | {"volumes": [], "surfaces": [WALL], "layers": LAYERS, "lights": []}, 16)
    assert mean(film, "albedo") == pytest.approx(0.25, rel=1e-5)
    assert mean(film, "normal") == pytest.approx([0, 0, -1], abs=1e-6)
    assert mean(film, "depth") == pytest.approx(5, rel=1e-6)
    assert mean(film, "position") == pytest.approx([0.5, 0.5, 4], rel=1e-3)
    assert mean(film, "optical_depth") == 0
    assert mean(film, "transmittance") == 0  # nothing comes through a wall


@pytest.mark.parametrize("as_grid", [False, True])
def test_a_medium(box: Box, grid: Callable[..., Any], picture: Picture, as_grid: bool) -> None:
    """σ_t = 2 in the unit cube, albedo 0.5: first collisions follow 2 exp(-2 z)."""
    if as_grid:
        box["volumes"] = [grid(np.ones((2, 3, 4), np.uint8), scale=2, albedo=0.5)]
    film = picture(box | {"layers": LAYERS}, 4096)
    through = np.exp(-2.0)
    assert mean(film, "transmittance") == pytest.approx(through, rel=0 if not as_grid else 3e-3, abs=1e-6)
    assert mean(film, "optical_depth") == pytest.approx(2, rel=1e-6 if not as_grid else 3e-3)
    assert mean(film, "albedo") == pytest.approx(0.5 * (1 - through), rel=3e-3)
    depth = (1 - 3 * through) / 2  # ∫ z 2 exp(-2 z) dz over the cube
    assert mean(film, "position")[2] == pytest.approx(depth, rel=3e-3)
    assert mean(film, "depth") == pytest.approx(depth + (1 - through), rel=3e-3)  # the camera is 1 away
    assert mean(film, "normal") == pytest.approx([0, 0, 0], abs=0)


def test_a_wall_behind_a_medium_and_glass(box: Box, picture: Picture) -> None:
    """Depth is that of the wall where the ray gets there; index-matched surfaces are not met."""
    box["volumes"][0] |= {"sigma_t": 1, "albedo": 0}
    pane = WALL | {"to_world": [[9, 0, 0, 0], [0, 9, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]], "material": {"kind": "null"}}
    film = picture(box | {"surfaces": [pane, WALL], "layers": LAYERS}, 4096)
    through = np.exp(-1.0)
    assert mean(film, "optical_depth") == pytest.approx(1, rel=1e-5)
    assert mean(film, "normal")[2] == pytest.approx(-through, rel=1e-2)
    inside = 1 - 2 * through  # ∫ z exp(-z) dz over the cube
    assert mean(film, "depth") == pytest.approx(5 * through + inside + (1 - through), rel=3e-3)
    assert mean(film, "albedo") == pytest.approx(0.25 * through, rel=1e-2)


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
