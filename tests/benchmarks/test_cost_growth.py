"""Cost grows as it should: time with samples, pixels, resolution and optical depth, memory with volume and film.

On a CPU the times are the processor's own, over all cores: what else the machine does changes little of them. Every
test adds what it found to `benchmarks/growth.json`.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.benchmarks.peers.scenes import noise
from tests.conftest import described

from woodcock.device import Device
from woodcock.launch import Launcher
from woodcock.plan import lay_out
from woodcock.predict import memory
from woodcock.probe import best_lanes, probe
from woodcock.program import Program
from woodcock.regression import Line, fit
from woodcock.render import Renderer, program_of, read_file

FOUND = Path(__file__).resolve().parents[2] / "benchmarks" / "growth.json"
SIGMA_T, ALBEDO = 40.0, 0.9
#: Each is timed so often, in turn with the others, and the least counts.
ROUNDS = 3
#: Seconds that the shortest render of a series takes at least: about fifty times what a launch costs beside it.
SHORTEST = 0.05

#: Writes the bytes of memory, at most, of a process that renders a scene: while it is made ready, and after that.
CHILD = """
import json, sys
from pathlib import Path
from woodcock.device import find
from woodcock.drive import drive
from woodcock.image import write_exr
from woodcock.render import Renderer
from woodcock.scene import load
def peak():
    return next(1024 * int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM"))
scene = load(Path(sys.argv[1]))
renderer = Renderer(scene, find(sys.argv[2]))
ready = peak()
Path("/proc/self/clear_refs").write_text("5")
film, _, _ = drive(renderer, scene, lambda *_: None)
write_exr(Path(sys.argv[1]).with_suffix(".exr"), film, {})
print(json.dumps([ready, peak()]))
"""
#: For glibc: large arrays are given back when they are freed. By default it keeps up to 32 MiB of each for later.
ALLOCATOR = {"MALLOC_MMAP_THRESHOLD_": str(1 << 20)}
#: Volumes in memory while a scene is made ready: the file's values, and the device's bricks.
WHILE_READ = 2
#: And while it renders: the device's. A CPU's is in the same memory.
WHILE_RENDERED = 1
#: Bytes of a pixel of one channel, while a launch's results are read back: the whole film (a count of 4, mean and M2 of
#: 8 each), sums (4 × 4) and audit (7 × 4) on the device and on the host, and the indices of pixels (4).
OF_A_PIXEL = 20 + 2 * (16 + 28) + 4

Values = NDArray[Any]


def add(device: Device, name: str, found: Any) -> None:
    """To the JSON file, under a name."""
    held = json.loads(FOUND.read_text()) if FOUND.exists() else {}
    FOUND.parent.mkdir(exist_ok=True)
    FOUND.write_text(json.dumps(held | {name: {"device": device.name, **found}}, indent=1, ensure_ascii=False) + "\n")


def table(title: str, rows: Sequence[dict[str, Any]]) -> None:
    print(f"\n{title}")
    print("".join(f"{key:>14}" for key in rows[0]))
    for row in rows:
        print("".join(f"{value:14.4g}" if isinstance(value, float) else f"{value!s:>14}" for value in row.values()))


def cloud(file: Path, values: Values, film: int, sigma_t: float = SIGMA_T) -> dict[str, Any]:
    """The peers' cloud, of these values [z][y][x] in the unit cube; bytes are in 255ths."""
    np.save(file, values)
    unit = 255 if values.dtype == np.uint8 else 1
    return {
        "camera": {
            "kind": "orthographic",
            "origin": [0.5, 0.5, -1],
            "target": [0.5, 0.5, 0.5],
            "up": [0, -1, 0],
            "height": 1,
        },
        "volumes": [{"kind": "grid", "file": str(file), "scale": sigma_t / unit, "albedo": ALBEDO}],
        "lights": [{"kind": "constant", "radiance": 1}],
        "film": {"width": film, "height": film},
        "stop": {"kind": "samples", "samples": 3},
    }


def quantised(values: Values) -> Values:
    return np.round(values * 255).astype(np.uint8)


def doubled(values: Values) -> Values:
    """The same field at twice the resolution: what trilinear interpolation gives in the middles of its voxels."""
    for axis in range(3):
        along = np.moveaxis(values, axis, 0)
        near, far = 0.75 * along, 0.25 * along
        both = np.empty((2 * len(along), *along.shape[1:]), values.dtype)
        both[0::2] = near + np.concatenate([far[:1], far[:-1]])
        both[1::2] = near + np.concatenate([far[1:], far[-1:]])
        values = np.ascontiguousarray(np.moveaxis(both, 0, axis))
    return values


@dataclass(frozen=True)
class Timed:
    """A scene on a device. loop: which of the two, and its majorant; steps: densities looked up, per path."""

    renderer: Renderer
    loop: str
    steps: float

    @classmethod
    def of(cls, scene: dict[str, Any], device: Device) -> Timed:
        model = described(scene)
        layout = lay_out(model, read_file)
        renderer = Renderer(model, device, layout=layout)
        program, _ = program_of(layout, device, renderer.lanes)
        # Were every density above its majorant, the audit would count what is looked up.
        text = program.text.replace("> 1.000001f", "> -1.f").replace("bound * 1.000001f", "bound * -1.f")
        assert text != program.text
        launcher = renderer._launcher
        counting = Launcher(launcher.context, Program(text, renderer.lanes), len(renderer.names), launcher.inputs)
        paths = model.film.width * model.film.height
        _, faults = counting.run(paths, 0, 1)
        loop = "full" if layout.integrator.endswith("full") else "lean"
        return cls(renderer, f"{loop}, {layout.kinds['majorant'][0]}", float(faults[4].sum(dtype=float)) / paths)

    @property
    def pixels(self) -> int:
        width, height = self.renderer.size
        return width * height

    def seconds(self, samples: int) -> float:
        clock = time.process_time if self.renderer.device.kind == "cpu" else time.perf_counter
        began = clock()
        self.renderer.render(0, samples)
        return clock() - began

    def enough(self) -> int:
        """Samples, a power of two, that take long enough to be timed."""
        samples = 16
        while self.seconds(samples) < SHORTEST:
            samples *= 2
        return samples


def least(renders: Sequence[tuple[Timed, int]]) -> list[float]:
    """Seconds of so many samples of each: the shortest, of rounds in which all take turns."""
    rounds = [[timed.seconds(samples) for timed, samples in renders] for _ in range(ROUNDS)]
    return [min(times) for times in zip(*rounds, strict=True)]


def exponent(x: Sequence[float], y: Sequence[float]) -> Line:
    """Of y ∝ x^slope, fitted to the logarithms."""
    return fit(np.log(x), np.log(y), np.eye(len(x)))


@pytest.mark.benchmark
@pytest.mark.timeout(600)
def test_time_is_proportional_to_samples_and_to_pixels(device: Device, tmp_path: Path) -> None:
    values, rows = quantised(noise(128)), list[dict[str, Any]]()
    films = [Timed.of(cloud(tmp_path / "cloud.npy", values, side), device) for side in (64, 128, 256, 512)]
    start = films[0].enough()
    counts = [start * 2**step for step in range(7)]
    for name, x, renders in (
        ("samples", counts, [(films[0], count) for count in counts]),
        ("pixels", [film.pixels for film in films], [(film, start) for film in films]),
    ):
        seconds = least(renders)
        line = exponent(x, seconds)
        row = {"against": name, "from": x[0], "to": x[-1], "seconds": seconds[0], "to seconds": seconds[-1]}
        rows.append(row | {"exponent": line.slope, "±": line.error})
    table(f"{device.name}: time against samples and pixels", rows)
    add(device, "work", {"rows": rows})
    for row in rows:
        assert 0.9 < row["exponent"] < 1.1, row["against"]


@pytest.mark.benchmark
@pytest.mark.timeout(900)
def test_time_hardly_grows_with_resolution(device: Device, tmp_path: Path) -> None:
    """One cloud at four resolutions: a path takes as many steps, but what it looks up lies further apart in memory."""
    middle, file = noise(128).astype(np.float32), tmp_path / "cloud.npy"
    clouds = [middle.reshape(64, 2, 64, 2, 64, 2).mean(axis=(1, 3, 5)), middle, doubled(middle)]
    clouds.append(doubled(clouds[-1]))
    rows, timed = list[dict[str, Any]](), list[Timed]()
    for values in [*map(quantised, clouds), *clouds]:
        timed.append(one := Timed.of(cloud(file, values, 256), device))
        rows.append({"voxels": f"{len(values)}³", "type": str(values.dtype), "loop": one.loop, "steps": one.steps})
    file.unlink()
    samples = timed[0].enough()
    for index, (row, seconds) in enumerate(zip(rows, least([(one, samples) for one in timed]), strict=True)):
        row["ns per path"] = 1e9 * seconds / (timed[index].pixels * samples)
        row["over 64³"] = row["ns per path"] / rows[index // 4 * 4]["ns per path"]
    table(f"{device.name}: time of a path against resolution, σ_t {SIGMA_T:g}, albedo {ALBEDO}", rows)
    add(device, "resolution", {"rows": rows})
    assert not [row for row in rows if row["over 64³"] >= 2]


@pytest.mark.benchmark
@pytest.mark.timeout(600)
def test_time_grows_slower_than_optical_depth(device: Device, tmp_path: Path) -> None:
    """However deep a cloud is, its paths end after a few dozen collisions: what grows is how many are tentative."""
    values, depths = quantised(noise(128)), [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0]
    timed = [Timed.of(cloud(tmp_path / "cloud.npy", values, 128, depth), device) for depth in depths]
    samples, rows = timed[0].enough(), list[dict[str, Any]]()
    for depth, one, seconds in zip(depths, timed, least([(one, samples) for one in timed]), strict=True):
        each = 1e9 * seconds / (one.pixels * samples)
        rows.append({"σ_t": depth, "loop": one.loop, "steps": one.steps, "ns per path": each})
        rows[-1]["ns per step"] = each / one.steps
    lines = {name: exponent(depths, [row[name] for row in rows]) for name in ("steps", "ns per path")}
    table(f"{device.name}: time of a path against σ_t, which is the unit cube's depth, albedo {ALBEDO}", rows)
    for name, line in lines.items():
        print(f"  {name} ∝ σ_t^({line.slope:.2f} ± {line.error:.2f})")
    add(device, "depth", {"rows": rows, "exponents": {name: line.slope for name, line in lines.items()}})
    assert lines["ns per path"].slope < 0.9


@pytest.mark.benchmark
@pytest.mark.timeout(600)
def test_memory_is_volume_and_film_and_a_constant(device: Device, tmp_path: Path) -> None:
    if device.kind != "cpu" or not Path("/proc/self/clear_refs").exists():
        pytest.skip("measured where the device's memory is the process's own, and Linux tells its peak")
    rng, rows, found = np.random.default_rng(1), list[dict[str, Any]](), list[list[int]]()
    cases = [(side, kind, 128) for kind in (np.uint8, np.float32) for side in (64, 128, 256, 384)]
    cases += [(64, np.uint8, 512), (64, np.uint8, 1024), (64, np.uint8, 2048), (256, np.float32, 1024)]
    for side, kind, film in cases:
        values = (rng.random((side,) * 3, np.float32) * 255).astype(kind)
        # So thin that a path takes no time.
        scene = cloud(tmp_path / "cloud.npy", values, film, 0.01)
        (file := tmp_path / "scene.json").write_text(json.dumps(scene))
        command, environment = [sys.executable, "-c", CHILD, str(file), device.id], os.environ | ALLOCATOR
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
        ready, rendering = json.loads(done.stdout)
        found.append([values.nbytes, film**2, ready, rendering])
        layout = lay_out(described(scene), read_file)
        stated = memory(layout, film, film, 1, best_lanes(device, probe(device)))
        row = {"voxels": f"{side}³", "type": str(values.dtype), "film": f"{film}²", "made ready": ready / 2**20}
        rows.append(row | {"rendering": rendering / 2**20, "stated": (stated["device"] + stated["host"]) / 2**20})
    volume, pixels, ready, rendering = np.array(found, float).T
    # By relative errors: the largest are ten times the smallest.
    terms = np.stack([np.ones(len(found)), volume, pixels], axis=1) / rendering[:, None]
    (constant, a, b), *_ = np.linalg.lstsq(terms, np.ones(len(found)))
    residual = float(abs(terms @ (constant, a, b) - 1).max())
    largest = volume.argmax()
    reading = float((ready[largest] - ready[0]) / (volume[largest] - volume[0]))
    table(f"{device.name}: memory in MiB at most, and as stated without what an empty process takes", rows)
    print(f"  rendering: {constant / 2**20:.0f} MiB + {a:.2f} × volume + {b:.0f} B × pixels, within {residual:.1%}")
    print(f"  made ready: {reading:.2f} × volume")
    fitted = {"constant": constant, "volume": a, "pixel": b, "residual": residual, "volume while made ready": reading}
    add(device, "memory", {"rows": rows, "fit": fitted})
    assert residual < 0.1
    assert a == pytest.approx(WHILE_RENDERED, rel=0.05)
    assert b == pytest.approx(OF_A_PIXEL, rel=0.1)
    assert reading == pytest.approx(WHILE_READ, rel=0.05)
