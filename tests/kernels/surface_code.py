"""Runs device functions of surfaces and materials over arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from tests.kernels.device_code import KIND_NEEDS

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.formats.mesh import Mesh
from woodcock.scene.surface import MeshSurface
from woodcock.space import Space
from woodcock.surface import build, compose

Array = np.ndarray[Any, Any]
SPACE = Space()


def built(surfaces: Sequence[Any], meshes: dict[str, Mesh] | None = None, space: Space = SPACE) -> build.Built:
    return build.build(build.place(surfaces, (), (meshes or {}).__getitem__), space)


def run(
    context: Context,
    world: build.Built,
    lanes: int,
    body: str,
    results: list[str],
    space: Space = SPACE,
    channels: int = 1,
    **inputs: Array,
) -> Array:
    """Evaluates expressions that see `world` and inputs (n,), or (n, 3) as vectors of their names."""
    composed = compose.compose(world, space, channels)
    buffers = {name: array for name, (_, array) in composed.buffers.items()}
    members = "".join(f" __global const {ctype} *{name};" for name, (ctype, _) in composed.buffers.items())
    flat, vectors = {}, ""
    for name, array in inputs.items():
        if array.ndim == 1:
            flat[name] = array
            continue
        flat |= {f"{name}_{axis}": np.ascontiguousarray(array[:, i]) for i, axis in enumerate("xyz")}
        vectors += f"vector {name} = vector_of({name}_x, {name}_y, {name}_z);\n"
    return evaluate(
        context,
        results,
        {name: array if array.dtype == np.uint32 else array.astype(np.float32) for name, array in flat.items()},
        lanes=lanes,
        parts=[
            *KIND_NEEDS[:-1],
            f"core/spectrum_{channels}.h",
            f"struct world {{{members} }};\n",
            *composed.parts,
        ],
        buffers=buffers,
        body=f"const struct world all = {{{', '.join(buffers)}}}, *world = &all;\n{vectors}{body}",
    )


def unit_vectors(n: int, seed: int) -> Array:
    v = np.random.default_rng(seed).standard_normal((n, 3))
    return (v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32)


def soup(corners: Array) -> tuple[MeshSurface, dict[str, Mesh]]:
    """A mesh surface of triangles (n, 3, 3)."""
    mesh = Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    return MeshSurface(file="soup"), {"soup": mesh}


def nearest(world: build.Built, origin: Array, direction: Array) -> Array:
    """Float64: distance (m,) to the nearest primitive, by the oracles, each tried."""
    best = np.full(len(origin), np.inf)
    for kind, numbers in world.numbers.items():
        oracle = build.module("surface", kind)
        exact = numbers.reshape(-1, oracle.WIDTH).astype(float)
        for part in np.array_split(exact, max(1, len(exact) // 256)):
            best = np.minimum(best, oracle.intersect(part, origin.astype(float), direction.astype(float)).min(axis=0))
    return best
