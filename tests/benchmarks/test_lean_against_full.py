"""What leaving out gains: every demo scene by its own program and by the one with everything switched on.

Scenes whose files are large lie in `../shared/data` beside the repository; where that is not there they are left out.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests import statistics

from woodcock.device import Device
from woodcock.film import Film
from woodcock.generic.gain import Gain, compared
from woodcock.plan import integrator
from woodcock.render import Renderer
from woodcock.scene import Scene, VolumetricPathIntegrator, load
from woodcock_client.demo import EXAMPLES, with_data

DATA = Path(__file__).resolve().parents[2].parent / "shared" / "data"
#: Pixels along the longer side, and samples of each, by which means are compared.
SIDE, SAMPLES = 96, 32
#: Of a program with less than this share of the source lines the scene uses little: it is to be so much faster.
LITTLE, MUCH = 0.25, 1.3
#: What a picture without noise may be off beside its bound: float32 in the other one.
ROUNDING = 1e-4


def demo_scenes() -> dict[str, Scene]:
    found = {path.stem: load(path) for path in sorted(EXAMPLES.glob("*.json"))}
    return found | (with_data(EXAMPLES / "data", DATA) if DATA.is_dir() else {})


def small(scene: Scene, seed: int) -> Scene:
    film, longer = scene.film, max(scene.film.width, scene.film.height)
    size = {side: max(1, SIDE * getattr(film, side) // longer) for side in ("width", "height")}
    return scene.model_copy(update={"film": film.model_copy(update=size), "seed": statistics.seed(seed)})


def same_mean(lean: Film, full: Film, name: str) -> None:
    for channel in range(full.channels):
        ours, its = lean.mean[..., channel], full.mean[..., channel]
        variance = lean.variance()[..., channel] + full.variance()[..., channel]
        allowed = 0.0 if lean.bound is None else float(lean.bound[..., channel].mean()) + ROUNDING * float(ours.mean())
        off = max(abs(float(ours.mean() - its.mean())) - allowed, 0.0)
        statistics.accept_z(off / (np.sqrt(variance.sum()) / ours.size), name, exact=False)


def by_paths(scene: Scene) -> Scene:
    """Samples without random numbers do not compare with others one by one."""
    return scene.model_copy(update={"integrator": VolumetricPathIntegrator()})


@pytest.mark.benchmark
@pytest.mark.timeout(1800)
def test_lean_against_full(device: Device) -> None:
    rows: dict[str, tuple[Gain, int, int]] = {}
    for name, scene in demo_scenes().items():
        full = Renderer(small(scene, 2), device, full=True)
        same_mean(Renderer(small(scene, 1), device).render(0, SAMPLES), full.render(0, SAMPLES), name)
        timed = by_paths(scene) if integrator(scene) != "volumetric_path" else scene
        lean, full = (Renderer(timed, device, full=full) for full in (False, True))
        lines = (one.facts()["program"]["source_lines"] for one in (lean, full))
        rows[name] = compared(lean, full), *lines
    print(f"\n{device.name}: seconds per sample of a pixel, everything switched on against what the scene needs")
    print(f"  {'scene':12} {'lines':>11} {'lean':>9} {'full':>9}   ratio (95 %)")
    for name, (gain, own, everything) in rows.items():
        interval = f"{gain['ratio']:.2f} ({gain['low']:.2f} to {gain['high']:.2f})"
        lines = f"{own}/{everything}"
        print(f"  {name:12} {lines:>11} {gain['lean']:9.2e} {gain['full']:9.2e}   {interval}")
    assert not [name for name, (gain, _, _) in rows.items() if gain["high"] < 1]
    little = {name: gain["ratio"] for name, (gain, own, everything) in rows.items() if own < LITTLE * everything}
    assert little
    assert not [name for name, ratio in little.items() if ratio < MUCH]
