"""Runs device functions of kinds over arrays, for the tests of kinds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from woodcock.device import Context
from woodcock.evaluate import evaluate
from woodcock.layout import Record, module

Floats = NDArray[np.float32]


def needs(channels: int) -> list[str]:
    """What program.py puts before every kind."""
    return ["core/rng.h", "core/vector.h", f"core/spectrum_{channels}.h"]


KIND_NEEDS = needs(1)


def call(
    context: Context,
    concept: str,
    model: Any,
    record: Mapping[str, Any],
    body: str,
    results: list[str],
    inputs: Mapping[str, NDArray[np.generic]],
    lanes: int,
    *,
    channels: int = 1,
    buffers: Mapping[str, NDArray[np.generic]] | None = None,
) -> Floats:
    """Evaluates expressions with `kind` pointing to the kind's struct in constant memory; `body` comes before them."""
    name = f"{concept}_{model.kind}"
    fields = module(concept, model.kind).FIELDS
    values = Record(concept, model.kind, "kind", fields, record)
    return evaluate(
        context,
        results,
        inputs,
        lanes=lanes,
        parts=[*needs(channels), struct(values), f"{concept}/{model.kind}.h", numbers(values, channels)],
        buffers=buffers,
        body=f"__constant const struct {name} *kind = &numbers;\n{body}",
    )


def numbers(record: Record, channels: int = 1) -> str:
    """A struct of constant memory, `numbers`."""
    return f"__constant struct {record.struct} numbers = {literal(record, channels)};\n"


def struct(record: Record) -> str:
    members = " ".join(f"{ctype} {name};" for name, ctype in record.fields.items())
    return f"struct {record.struct} {{ {members} }};\n"


def literal(record: Record, channels: int = 1) -> str:
    """The struct's numbers as a C initialiser, exact: floats in hexadecimal."""
    parts = []
    for name, ctype in record.fields.items():
        value = np.asarray(record.values[name])
        if ctype == "int":
            parts.append(str(int(value)))
        elif value.ndim == 0 or (ctype == "colour" and channels == 1):
            parts.append(f"{float(np.float32(value.reshape(-1)[0])).hex()}f")
        else:
            value = np.broadcast_to(value, channels) if ctype == "colour" else value
            parts.append("{" + ", ".join(f"{float(np.float32(v)).hex()}f" for v in value.reshape(-1)) + "}")
    return "{" + ", ".join(parts) + "}"
