"""The renderer against the speed floor: a bare kernel that does nothing but track through one grid.

`../shared/spikes/lanes` beside the repository holds that kernel; both render its cloud in turn, in one run, at the
same lane width, and are compared by efficiency, 1 / (mse · seconds).
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from woodcock.device import Context, Device
from woodcock.probe import best_lanes, probe

SPIKE = Path(__file__).resolve().parents[2].parent / "shared" / "spikes" / "lanes"
ROUNDS = 5
SAMPLES = 256


@pytest.fixture
def spike(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    if not SPIKE.is_dir():
        pytest.skip(f"the speed floor's kernel is not there: {SPIKE}")
    monkeypatch.syspath_prepend(str(SPIKE))
    import run

    return run


def floor(spike: ModuleType, density: np.ndarray, context: Context, lanes: int) -> Callable[[int], np.ndarray]:
    """The bare kernel: 16 samples a pixel of a seed, (256, 256)."""
    n, width = spike.N, spike.WIDTH
    bricks = np.ascontiguousarray(density.reshape((n // 4, 4) * 3).transpose(0, 2, 4, 1, 3, 5))
    source = (SPIKE / "lanes.h").read_text() + (SPIKE / "path.cl").read_text()
    kernel = context.build(source, (f"-DN={n}", f"-DLANES={lanes}"), "path")
    uploaded = context.upload(bricks)
    image, steps = np.zeros((width, width), np.float32), np.zeros((width, width // lanes), np.uint32)
    out, count = context.output(image), context.output(steps)
    numbers = (np.int32(width), np.int32(width), np.int32(spike.SPP), np.float32(spike.SIGMA), np.float32(spike.ALBEDO))

    def render(seed: int) -> np.ndarray:
        kernel(context.queue, (width // lanes, width), None, uploaded, out, *numbers, np.uint32(seed), count)
        context.download(image, out)
        return image.astype(float)

    return render


@pytest.mark.benchmark
@pytest.mark.timeout(900)
def test_speed_floor(spike: ModuleType, device: Device, tmp_path: Path) -> None:
    lanes = best_lanes(device, probe(device))
    density = np.round(spike.cloud(spike.N) * 255).astype(np.uint8)
    np.save(tmp_path / "cloud.npy", density)
    scene = {
        "camera": {
            "kind": "orthographic",
            "origin": [0.5, 0.5, -1],
            "target": [0.5, 0.5, 0.5],
            "up": [0, -1, 0],
            "height": 1,
        },
        "volumes": [{"kind": "grid", "file": "cloud.npy", "scale": spike.SIGMA / 255, "albedo": spike.ALBEDO}],
        "lights": [{"kind": "constant", "radiance": 1}],
        "film": {"width": spike.WIDTH, "height": spike.WIDTH},
        "stop": {"kind": "samples", "samples": SAMPLES},
    }
    (tmp_path / "cloud.json").write_text(json.dumps(scene))
    bare = floor(spike, density, Context.on(device), lanes)
    one, two = bare(1001), bare(1002)
    bare_mse = float(np.mean((one - two) ** 2)) / 2
    command = [sys.executable, "-m", "woodcock_client.cli", "render", "cloud.json", "-o", "cloud.exr"]

    rows = []
    for turn in range(ROUNDS):
        began = time.perf_counter()
        means = [bare(seed).mean() for seed in range(turn * 16, turn * 16 + SAMPLES // spike.SPP)]
        seconds = (time.perf_counter() - began) / len(means)
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
        report = json.loads((tmp_path / "cloud.report.json").read_text())
        # The mean first: a fast wrong picture is worth nothing.
        assert report["mean_luminance"] == pytest.approx(np.mean(means), abs=5e-4)
        rows.append((1 / (bare_mse * seconds), 1 / (report["rmse"] ** 2 * report["seconds"]["render"])))
    ratios = [ours / floor for floor, ours in rows]
    print(f"\n{device.name}, {lanes} lanes; efficiency 1/(mse·s), median of {ROUNDS} rounds in turn")
    print(f"  bare kernel      {np.median([floor for floor, _ in rows]):8.0f}")
    print(f"  woodcock render  {np.median([ours for _, ours in rows]):8.0f}")
    print(f"  ratio            {np.median(ratios):8.2f}   (from {min(ratios):.2f} to {max(ratios):.2f})")
    assert np.median(ratios) >= 0.8
