"""How far the cloud is from what its device could do.

A tentative collision needs four random words, the logarithm of one, a point on the ray, a voxel near it and one lookup.
Two micro-kernels do just that, with every lane at work in every step and nothing that waits for anything:

- arithmetic: `rng_next`, `rng_flight`, the point and the voxel's index by the renderer's own files, without the lookup;
- lookups: random ones in a run of bytes as long as the volume, an integer product and a sum beside each.

A processor that overlaps both perfectly cannot be faster than the slower of the two: that is the limit here, in time
per tentative collision and lane. What a path does beside (cells that it crosses, new directions, new paths, lanes that
wait for others) is not in it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.benchmarks.peers.scenes import CASES

from woodcock import render
from woodcock.device import Context, Device
from woodcock.probe import best_lanes, probe
from woodcock.program import OPTIONS, Program, compose, flatten
from woodcock.render import Renderer
from woodcock.scene import Scene

ITEMS, EVENTS, ROUNDS = 2048, 4000, 5
SAMPLES = 64

KERNELS = """
static inline integer voxel(real x, word jitter, int size) {
    real raised = x + 0.5f + to_real(word_as_integer(jitter)) * 0x1p-21f;
    return clamp_index(to_integer(raised) - 1, size);
}
__kernel void arithmetic(__global float *result, uint events, int size) {
    const uint lane0 = get_global_id(0) * LANES;
    rng_address at = {(word)lane0 + integer_as_word(lane_index()), (word)0u, (word)0u, 7u};
    const vector origin = {(real)1.f, (real)2.f, (real)3.f}, along = {(real)0.3f, (real)0.4f, (real)0.5f};
    real sum = (real)0.f;
    for (uint event = 0; event < events; ++event) {
        words w = rng_next(&at, (mask)-1);
        real u, depth = rng_flight(&at, w, &u);
        vector p = vector_along(origin, depth, along);
        integer i = voxel(p.x, w.y >> 11u, size), j = voxel(p.y, w.z >> 11u, size);
        integer k = voxel(p.z, ((w.y & 2047u) << 10u) | (w.z & 1023u), size);
        integer brick = ((k >> 2) * (size / 4) + (j >> 2)) * (size / 4) + (i >> 2);
        integer index = (brick << 6) | ((k & 3) << 4) | ((j & 3) << 2) | (i & 3);
        sum += pick((real)0.f, to_real(index), test(u < 0.5f));
    }
    lanes_store(sum, result + lane0);
}
__kernel void lookups(__global float *result, uint events, __global const uchar *values, int bits) {
    const uint lane0 = get_global_id(0) * LANES;
    word hash = (word)(lane0 * 977u) + integer_as_word(lane_index()) * 7919u;
    real sum = (real)0.f;
    for (uint event = 0; event < events; ++event) {
        hash = hash * 1664525u + 1013904223u;
        sum += to_real(gather(uchar, values, word_as_integer(hash >> (uint)(32 - bits))));
    }
    lanes_store(sum, result + lane0);
}
"""


def least(run: Callable[[], object]) -> float:
    """Seconds; the first run is not counted."""
    times = []
    for _ in range(ROUNDS + 1):
        began = time.perf_counter()
        run()
        times.append(time.perf_counter() - began)
    return min(times[1:])


def limits(device: Device, lanes: int, density: np.ndarray) -> dict[str, float]:
    """Seconds per event and lane of the device as a whole."""
    context = Context.on(device)
    files = [f"core/lanes_{lanes}.h", "core/precision_float.h", "core/rng.h", "core/vector.h"]
    text = flatten([*files, KERNELS])
    result = context.output(np.zeros(ITEMS * lanes, np.float32))
    values = context.upload(density.reshape(-1))
    bits = density.size.bit_length() - 1
    calls: dict[str, tuple[Any, ...]] = {
        "arithmetic": (np.int32(density.shape[0]),),
        "lookups": (values, np.int32(bits)),
    }

    def seconds(name: str) -> float:
        kernel = context.build(text, OPTIONS, name)

        def run() -> None:
            kernel(context.queue, (ITEMS,), None, result, np.uint32(EVENTS), *calls[name])
            context.queue.finish()

        return least(run) / (ITEMS * lanes * EVENTS)

    return {name: seconds(name) for name in calls}


def tentative(scene: Scene, device: Device, monkeypatch: pytest.MonkeyPatch) -> float:
    """Tentative collisions per path: the program's own audit, told that each of them exceeds its majorant."""
    threshold = "test(density > 1.000001f)"

    def counting(*arguments: Any, **options: Any) -> Program:
        program = compose(*arguments, **options)
        assert program.text.count(threshold) == 1
        return replace(program, text=program.text.replace(threshold, "test(density >= 0.f)"))

    with monkeypatch.context() as patch:
        patch.setattr(render, "compose", counting)
        patch.setattr(render, "MOST_ROUNDS", 0)
        film = Renderer(scene, device).render(0, 4)
    return film.faults.violations / (4 * film.count.size)


@pytest.mark.benchmark
def test_distance_from_limit(device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (case,) = (case for case in CASES if case.name == "cloud")
    described = case.written(tmp_path)
    monkeypatch.chdir(tmp_path)
    lanes = best_lanes(device, probe(device))
    slowest = limits(device, lanes, np.load("density.npy"))
    limit = max(slowest.values())
    print(f"\n{device.name}, {lanes} lanes, {device.compute_units} compute units; of the device as a whole")
    for name, seconds in slowest.items():
        print(f"  {name:12s} {1e-6 / seconds:8.0f} million events a second")
    majorants: Mapping[str, Any] = {"chosen": None, "one": {"kind": "global"}}
    reached = {}
    for name, majorant in majorants.items():
        scene = Scene.model_validate(described | {"majorant": majorant})
        events, renderer = tentative(scene, device, monkeypatch), Renderer(scene, device)
        paths = SAMPLES * scene.film.width * scene.film.height
        seconds = least(lambda renderer=renderer: renderer.render(0, SAMPLES)) / (paths * events)  # type: ignore[misc]
        reached[name] = limit / seconds
        print(
            f"  majorant {name:6s} {events:6.2f} tentative collisions a path, {1e-6 / seconds:6.0f} million a second, "
            f"{seconds * device.compute_units * 1e9:5.1f} ns of a core each; {reached[name]:.0%} of the limit"
        )
    assert max(reached.values()) >= 0.5
