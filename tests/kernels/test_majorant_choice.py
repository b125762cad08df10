"""Which majorant a scene gets that names none."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from woodcock.formats import Grid
from woodcock.plan import lay_out, settled
from woodcock.scene import Scene, parse

N = 48


def scene(scale: float, **keys: Any) -> Scene:
    return parse(
        json.dumps(
            {
                "camera": {"kind": "orthographic", "origin": [0, 0, 5], "target": [0, 0, 0], "height": 1},
                "volumes": [{"kind": "grid", "file": "x", "scale": scale, "albedo": 0.5}],
                "lights": [{"kind": "constant", "radiance": 1}],
                **keys,
            }
        )
    )


def even(file: str, name: str | None) -> Grid:
    return Grid("density", np.ones((N, N, N), np.float32), np.diag([1 / N, 1 / N, 1 / N, 1]), placed=True)


def sparse(file: str, name: str | None) -> Grid:
    values = np.zeros((N, N, N), np.float32)
    values[20:24, 20:24, 20:24] = 1
    return Grid("density", values, np.diag([1 / N, 1 / N, 1 / N, 1]), placed=True)


@pytest.mark.parametrize(
    ("grid", "scale", "kind"),
    [(even, 1.0, "global"), (even, 1000.0, "global"), (sparse, 1.0, "global"), (sparse, 1000.0, "grid")],
)
def test_cells_are_walked_where_they_save_steps(grid: Any, scale: float, kind: str) -> None:
    found = settled(scene(scale), grid)
    assert found.majorant is not None
    assert found.majorant.kind == kind
    assert lay_out(scene(scale), grid).kinds["majorant"] == (kind,)


def test_what_a_scene_names_is_kept() -> None:
    asked = scene(1000.0, majorant={"kind": "global"})
    assert settled(asked, sparse) is asked


def test_the_small_loop_is_worth_some_steps() -> None:
    """15 mean free paths are too few to leave it; a scene that it does not suit walks from cell to cell."""
    thin = scene(15 * 1.5)  # the mean chord of a cube is 2/3 of its side
    assert settled(thin, sparse).majorant == settled(thin, even).majorant
    full = settled(scene(15 * 1.5, orders=1), sparse).majorant
    assert full is not None
    assert full.kind == "grid"
