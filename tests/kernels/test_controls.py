"""Controls: lower bounds on σ_t in the cells of a majorant, for decomposition tracking and residual ratio tracking."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from tests.analytic.scenes import Grid, Kind, Scene, is_clean, random_walk
from tests.conftest import described
from tests.kernels.grid_rays import changed, field_of, placed
from tests.kernels.test_majorant import random_media
from tests.statistics import accept_z

from woodcock import render
from woodcock.device import Device
from woodcock.formats import Grid as Values
from woodcock.plan import lay_out
from woodcock.scene import GlobalMajorant, GridMajorant, GridVolume
from woodcock.space import Array, Space
from woodcock.volume import grid as grids
from woodcock.volume.compose import compose
from woodcock.volume.media import Medium, read_media

MAJORANTS: dict[str, Kind] = {"global": {"kind": "global"}, "grid": {"kind": "grid", "resolution": 3}}


def channels_of(media: Sequence[Medium], points: Array) -> Array:
    """(n, 3): Σ σ_t of what is stored."""
    total = np.zeros((len(points), 3))
    for medium in media:
        field, volume = medium.density, medium.volume
        assert isinstance(volume, GridVolume)
        assert field is not None
        stored = Values("x", field.decoded(0, field.size[2]), field.grid.index_to_world, placed=True)
        density = grids.density(volume, stored, points)
        total += density if density.ndim == 2 else density[:, None]
    return total


@pytest.mark.parametrize("seed", range(24))
def test_controls_bound_from_below_and_residuals_from_above(seed: int) -> None:
    random = np.random.default_rng(seed)
    media = random_media(random, 1 + seed % 3)
    for medium in media:  # not sparse, so that some cells have a control
        assert medium.density is not None
        values = medium.density.grid.values
        values += (0.3 * random.random(values.shape) + 0.1).astype(np.float32)
    majorant = GlobalMajorant() if seed % 4 == 3 else GridMajorant(resolution=int(random.integers(1, 20)))
    composed = compose(media, Space(), majorant, control=True, residual=True)
    tracking, record = (record.values for record in composed.records[:2])
    cells = np.array([record[f"cells_{axis}"] for axis in "xyz"] if majorant.kind == "grid" else [1, 1, 1])
    control = np.zeros((*cells[::-1], 3))
    for index, medium in enumerate(media):
        assert isinstance(medium.volume, GridVolume)
        assert medium.density is not None
        least = [composed.buffers[f"minorant_{index}_{c}"].array() for c in range(medium.density.channels)]
        step = np.array(medium.volume.scale) * medium.density.step
        control += np.stack(least, axis=-1).reshape(*cells[::-1], -1) * step
    residual = composed.buffers["majorant_residual"].array().reshape(cells[::-1])
    local = random.random((20000, 3)) * tracking["size"]
    back = np.linalg.inv(np.vstack([tracking["to_local"], [0, 0, 0, 1]]))
    found = channels_of(media, local @ back[:3, :3].T + back[:3, 3])
    for nudge in (-1e-7, 0, 1e-7):
        x, y, z = np.clip(np.floor(local * (cells / tracking["size"]) * (1 + nudge)), 0, cells - 1).astype(int).T
        assert np.all(control[z, y, x] <= found * (1 + 1e-6))
        assert np.all(
            (found - control[z, y, x]).max(axis=1) <= residual[z, y, x] * (1 + 1e-6) + 1e-6 * found.max(axis=1)
        )
    if len(media) == 1:
        assert control.max() > 0


def test_controls_are_tight() -> None:
    """The least of a cell is that of its voxels and of those that its interpolation reaches."""
    values = np.full((8, 8, 8), 5, np.float32)
    values[4, 4, 4] = 2
    media = field_of(values).scene(3.0).volumes
    (medium,) = read_media(media, lambda file, name: placed(values))
    buffers = compose([medium], Space(), GridMajorant(resolution=8), control=True, residual=True).buffers
    assert medium.density is not None
    control = buffers["minorant_0_0"].array().reshape(8, 8, 8) * medium.density.step * 3
    assert set(np.argwhere(control < 15).flatten()) == {3, 4, 5}
    assert control.max() == 15
    assert control.min() == 6
    assert np.allclose(buffers["majorant_residual"].array().reshape(8, 8, 8), 15 - control, atol=1e-4)


@pytest.mark.parametrize(("flight", "transmittance"), [("decomposition", "ratio"), ("delta", "residual_ratio")])
@pytest.mark.parametrize("majorant", MAJORANTS)
def test_a_control_too_high_is_found_and_repaired(
    box: Scene,
    grid: Grid,
    device: Device,
    monkeypatch: pytest.MonkeyPatch,
    flight: str,
    transmittance: str,
    majorant: str,
) -> None:
    layers = np.array([1, 0.4, 0.5, 1.1], np.float32).reshape(4, 1, 1)
    scene = random_walk(box, volumes=[grid(layers, scale=2, albedo=0)], layers=["transmittance"])
    scene |= {
        "free_flight": {"kind": flight},
        "transmittance": {"kind": transmittance},
        "majorant": MAJORANTS[majorant],
    }
    right = lay_out(described(scene), render.read_file)
    assert any(name.startswith("minorant_") for name in right.buffers)
    assert is_clean(render.Renderer(described(scene), device).render(0, 64))
    monkeypatch.setattr(render, "lay_out", lambda scene, read: changed(lay_out(scene, read), {"minorant_": 1.6}))
    film = render.Renderer(described(scene), device).render(0, 256)
    assert film.violations == 0
    assert film.faults.repaired > 0
    accept_z((film.mean_luminance() - np.exp(-1.5)) / film.mean_luminance_error())
    layer = film.layer("transmittance")
    assert layer.mean.mean() == pytest.approx(np.exp(-1.5), abs=0.01)
