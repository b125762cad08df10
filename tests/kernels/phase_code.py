"""Runs the phase functions of media over arrays, through the code composed for them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from tests.kernels.device_code import KIND_NEEDS, literal, struct

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.layout import element
from woodcock.phase.compose import compose
from woodcock.scene import Phase

Floats = NDArray[np.float32]


def run(
    context: Context,
    phases: Sequence[Phase],
    lanes: int,
    results: list[str],
    inputs: dict[str, NDArray[np.generic]],
    body: str = "",
) -> Floats:
    """Expressions with `world` as their handle; inputs of (3, n) become vectors, `index` the `medium`."""
    code = compose(phases)
    scene = "".join(f"struct {record.struct} {record.member}; " for record in code.records)
    buffers = "".join(f"__global const {element(array)} *{name}; " for name, array in code.buffers.items())
    numbers = ", ".join(literal(record) for record in code.records)
    parts = [
        *KIND_NEEDS,
        *{record.struct: struct(record) for record in code.records}.values(),
        f"struct scene {{ {scene}}};\nstruct world {{ __constant const struct scene *scene; {buffers}}};\n",
        *(f"phase/{kind}.h" for kind in code.kinds),
        code.text,
        f"__constant struct scene numbers = {{{numbers}}};\n",
    ]
    members = "".join(f", {name}" for name in code.buffers)
    before = f"const struct world here = {{&numbers{members}}}, *world = &here;\n"
    flat: dict[str, NDArray[np.generic]] = {}
    for name, array in inputs.items():
        if array.ndim == 1:
            flat[name] = array
            continue
        flat |= {f"{name}_{axis}": array[i] for i, axis in enumerate("xyz")}
        before += f"vector {name} = vector_of({name}_x, {name}_y, {name}_z);\n"
    before += "integer medium = to_integer(index);\n" if "index" in inputs else "integer medium = (integer)0;\n"
    return evaluate(context, results, flat, lanes=lanes, parts=parts, buffers=code.buffers, body=before + body)


def unit_vectors(n: int, seed: int) -> Floats:
    v = np.random.default_rng(seed).standard_normal((3, n))
    return (v / np.linalg.norm(v, axis=0)).astype(np.float32)


def exactly_unit(v: Floats) -> NDArray[np.float64]:
    return v.astype(float) / np.linalg.norm(v.astype(float), axis=0)
