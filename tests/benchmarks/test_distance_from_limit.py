"""How far the cloud is from what its device could do.

A path is T tentative collisions, of which C are real, and it begins and ends once; T and C are counted by the program
itself. What each of these needs by definition is done by a micro-kernel of its own, by the renderer's own files, with
every lane at work in every step and nothing decided by what is found:

- tentative: four random words, the logarithm of one, a point on the ray, and the voxel near it that is picked;
- scattering: four random words, a direction and its length to the volume's end;
- path: four random words, a camera ray clipped to the volume, and the film's sums.

T tentative + C scattering + path is the limit. Lanes that wait for others are not in it, and neither are a grid's cells
that a path crosses: those are what its fewer tentative collisions cost. Two more micro-kernels take a tentative
collision apart: its arithmetic without the lookup, and random lookups in a run of bytes as long as the volume without
the arithmetic. A processor that did both at once for the price of the dearer would have a second limit, which is told,
too; the first kernel shows what this one makes of them.
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
#: Tentative collisions of a flight under one bound: as many as the cloud's, whose side is 40 mean free paths, roughly.
FLIGHT = 16

KERNELS = """
static inline integer voxel(real x, word jitter, int size) {
    real raised = x + 0.5f + to_real(word_as_integer(jitter)) * 0x1p-21f;
    return clamp_index(to_integer(raised) - 1, size);
}
static inline integer voxel_index(vector p, words w, int size) {
    integer i = voxel(p.x, w.y >> 11u, size), j = voxel(p.y, w.z >> 11u, size);
    integer k = voxel(p.z, ((w.y & 2047u) << 10u) | (w.z & 1023u), size);
    integer brick = ((k >> 2) * (size / 4) + (j >> 2)) * (size / 4) + (i >> 2);
    return (brick << 6) | ((k & 3) << 4) | ((j & 3) << 2) | (i & 3);
}
// Along rays from random places in random directions, as long as flights are.
__kernel void tentative(__global float *result, uint events, __global const uchar *values, int size, float free_path,
                        uint flight) {
    const uint lane0 = get_global_id(0) * LANES;
    rng_address at = {(word)lane0 + integer_as_word(lane_index()), (word)0u, (word)0u, 7u};
    vector origin, along;
    real t, sum = (real)0.f;
    for (uint event = 0; event < events; ++event) {
        if (event % flight == 0) {
            words v = rng_words(&at, ~at.dimension);
            origin = vector_of(unit(v.x) * (float)size, unit(v.y) * (float)size, unit(v.z) * (float)size);
            along = phase_isotropic_sample(0, origin, unit(v.w), unit(v.x << 8u));
            t = (real)0.f;
        }
        words w = rng_next(&at, (mask)-1);
        real u, depth = rng_flight(&at, w, &u);
        t += depth * free_path;
        real value = to_real(gather(uchar, values, voxel_index(vector_along(origin, t, along), w, size)));
        sum += pick((real)0.f, t, test(255.f * u < value));
    }
    lanes_store(sum, result + lane0);
}
__kernel void arithmetic(__global float *result, uint events, int size) {
    const uint lane0 = get_global_id(0) * LANES;
    rng_address at = {(word)lane0 + integer_as_word(lane_index()), (word)0u, (word)0u, 7u};
    const vector origin = {(real)1.f, (real)2.f, (real)3.f}, along = {(real)0.3f, (real)0.4f, (real)0.5f};
    real sum = (real)0.f;
    for (uint event = 0; event < events; ++event) {
        words w = rng_next(&at, (mask)-1);
        real u, depth = rng_flight(&at, w, &u);
        integer index = voxel_index(vector_along(origin, depth, along), w, size);
        sum += pick((real)0.f, to_real(index), test(u < 0.5f));
    }
    lanes_store(sum, result + lane0);
}
__kernel void scattering(__global float *result, uint events, __constant const affine *to_local, float size) {
    const uint lane0 = get_global_id(0) * LANES;
    rng_address at = {(word)lane0 + integer_as_word(lane_index()), (word)0u, (word)0u, 7u};
    const vector3 box = {size, size, size};
    const vector inside = {(real)1.f, (real)2.f, (real)3.f};
    real sum = (real)0.f, throughput = (real)1.f;
    for (uint event = 0; event < events; ++event) {
        words v = rng_next(&at, (mask)-1);
        real chance = roulette_chance(throughput);
        throughput = pick(throughput / chance, (real)1.f, test(unit(v.x) >= chance)) * 0.9f;
        vector along = affine_direction(to_local, phase_isotropic_sample(0, inside, unit(v.z), unit(v.w)));
        sum += throughput * box_exit(box, inside, along);
    }
    lanes_store(sum, result + lane0);
}
__kernel void path(__global float *result, uint events, __constant const affine *to_local, float size) {
    const uint lane0 = get_global_id(0) * LANES;
    rng_address at = {(word)lane0 + integer_as_word(lane_index()), (word)0u, (word)0u, 7u};
    const vector3 box = {size, size, size};
    moments sums = {(real)0.f, (real)0.f, (real)0.f, (real)0.f};
    for (uint event = 0; event < events; ++event) {
        words w = rng_next(&at, (mask)-1);
        vector anchor = affine_point(to_local, vector_of(unit(w.x), unit(w.y), (real)0.f));
        vector along = affine_direction(to_local, vector_of(unit(w.z), (real)0.f, (real)1.f));
        real near = (real)0.f, far = (real)1e30f;
        box_clip(box, anchor, along, &near, &far);
        moments_add(&sums, far - near);
    }
    lanes_store(sums.sum + sums.square, result + lane0);
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


def limits(device: Device, lanes: int, density: np.ndarray, depth: float) -> dict[str, float]:
    """Seconds per event and lane of the device as a whole. depth: of the volume's side by the majorant."""
    context = Context.on(device)
    names = ("rng", "vector", "box", "roulette", "sincos", "moments")
    files = [f"core/lanes_{lanes}.h", "core/precision_float.h", *(f"core/{name}.h" for name in names)]
    text = flatten([*files, "struct phase_isotropic { int unused; };\n", "phase/isotropic.h", KERNELS])
    result = context.output(np.zeros(ITEMS * lanes, np.float32))
    values = context.upload(density.reshape(-1))
    bits, side = density.size.bit_length() - 1, np.int32(density.shape[0])
    place = context.upload(np.eye(3, 4, dtype=np.float32) * density.shape[0]), np.float32(density.shape[0])
    calls: dict[str, tuple[Any, ...]] = {
        "tentative": (values, side, np.float32(side / depth), np.uint32(FLIGHT)),
        "arithmetic": (side,),
        "scattering": place,
        "path": place,
        "lookups": (values, np.int32(bits)),
    }

    def seconds(name: str) -> float:
        kernel = context.build(text, OPTIONS, name)

        def run() -> None:
            kernel(context.queue, (ITEMS,), None, result, np.uint32(EVENTS), *calls[name])
            context.queue.finish()

        return least(run) / (ITEMS * lanes * EVENTS)

    return {name: seconds(name) for name in calls}


def collisions(scene: Scene, device: Device, monkeypatch: pytest.MonkeyPatch, which: str) -> float:
    """Collisions per path that meet a condition: the program's own audit, told that these exceed their majorant."""
    threshold = "test(density > 1.000001f)"

    def counting(*arguments: Any, **options: Any) -> Program:
        program = compose(*arguments, **options)
        assert program.text.count(threshold) == 1
        return replace(program, text=program.text.replace(threshold, which))

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
    least_of = limits(device, lanes, np.load("density.npy"), 40)
    print(f"\n{device.name}, {lanes} lanes, {device.compute_units} compute units; of the device as a whole")
    for name, seconds in least_of.items():
        print(f"  {name:12s} {1e-6 / seconds:8.0f} million events a second")
    majorants: Mapping[str, Any] = {"chosen": None, "one": {"kind": "global"}}
    reached = {}
    for name, majorant in majorants.items():
        scene = Scene.model_validate(described | {"majorant": majorant})
        tentative = collisions(scene, device, monkeypatch, "test(density >= 0.f)")
        real = collisions(scene, device, monkeypatch, "free_flight_collides(density, u)")
        renderer, paths = Renderer(scene, device), SAMPLES * scene.film.width * scene.film.height
        seconds = least(lambda renderer=renderer: renderer.render(0, SAMPLES)) / paths  # type: ignore[misc]
        rest = real * least_of["scattering"] + least_of["path"]
        reached[name] = (tentative * least_of["tentative"] + rest) / seconds
        perfect = max(tentative * least_of["arithmetic"] + rest, tentative * least_of["lookups"]) / seconds
        each = seconds / tentative
        print(
            f"  majorant {name:6s} {tentative:6.2f} tentative collisions a path, {real:.2f} of them real; "
            f"{1e-6 / each:6.0f} million a second, {each * device.compute_units * 1e9:5.1f} ns of a core each; "
            f"{reached[name]:.0%} of the limit, {perfect:.0%} of that of perfect overlap"
        )
    assert max(reached.values()) >= 0.5
