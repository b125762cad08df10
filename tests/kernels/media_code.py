"""Evaluates the functions that `volume/compose.py` writes for media, for the tests of volumes and emission."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tests.kernels.device_code import literal

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.volume.text import Composed

Floats = NDArray[np.float32]


def ask(
    context: Context,
    composed: Composed,
    expressions: Sequence[str],
    inputs: Mapping[str, NDArray[np.generic]],
    lanes: int,
    *,
    body: str = "",
    channels: int = 1,
    extra: str = "",
) -> Floats:
    """The expressions' values; they see `world`, with the composed media in it, and the point p = (x, y, z)."""
    records = composed.records
    structs = {}
    for record in records:
        members = " ".join(f"{ctype} {name};" for name, ctype in record.fields.items())
        structs[record.struct] = f"struct {record.struct} {{ {members} }};\n"
    members = " ".join(f"struct {record.struct} {record.member};" for record in records)
    arrays: dict[str, Any] = dict(composed.buffers)
    pointers = "".join(f" __global const {_element(array)} *{name};" for name, array in arrays.items())
    values = ", ".join(literal(record, channels) for record in records)
    parts = [
        "core/rng.h",
        "core/vector.h",
        f"core/spectrum_{channels}.h",
        "".join(structs.values()) + f"struct scene {{ {members} }};\n",
        *composed.files,
        f"struct world {{ __constant const struct scene *scene;{pointers} }};\n",
        composed.text or "\n",
        f"__constant struct scene numbers = {{{values}}};\n{extra}",
    ]
    world = ", ".join(["&numbers", *arrays])
    start = f"const struct world here = {{{world}}}, *world = &here;\nvector p = vector_of(x, y, z);\n"
    return evaluate(context, expressions, inputs, lanes=lanes, parts=parts, buffers=arrays, body=start + body)


def _element(array: Any) -> str:
    return {"f4": "float", "u2": "ushort", "u1": "uchar"}[array.dtype.str[1:]]
