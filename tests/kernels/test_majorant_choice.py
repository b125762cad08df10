"""Which majorant a scene gets that names none."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from woodcock.formats import Grid
from woodcock.plan import lay_out, settled
from woodcock.scene import GlobalMajorant, GridMajorant, Scene, parse

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


def shells(file: str, name: str | None) -> Grid:
    """Thin shells, dense inside: the finer the cells, the fewer the null collisions."""
    z, y, x = np.meshgrid(*[np.arange(N) - N / 2] * 3, indexing="ij")
    distance = np.sqrt(x**2 + y**2 + z**2)
    values = np.where(distance < N / 2, np.exp(-distance / 3), 0).astype(np.float32)
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


def test_denser_media_get_finer_cells() -> None:
    """A crossing costs the same in all of them, null collisions grow with σ_t."""
    found = [settled(scene(scale), shells).majorant for scale in (1.0, 20.0, 500.0, 3000.0)]
    cells = [GridMajorant(resolution=8), GridMajorant(resolution=16), GridMajorant(resolution=48, blocks=True)]
    assert found == [GlobalMajorant(), *cells]


def test_a_dense_core_in_haze_gets_fine_cells_in_blocks() -> None:
    def core(file: str, name: str | None) -> Grid:
        haze = np.full((64, 64, 64), 5e-5, np.float32)
        haze[28:36, 28:36, 28:36] = 1
        return Grid("density", haze, np.diag([1 / 64, 1 / 64, 1 / 64, 1]), placed=True)

    assert settled(scene(1e4), core).majorant == GridMajorant(resolution=96, blocks=True)


def test_either_majorant_leaves_a_plain_scene_to_the_small_loop() -> None:
    for scale in (1.0, 1000.0):
        assert lay_out(scene(scale), sparse).integrator == "volumetric_path"
