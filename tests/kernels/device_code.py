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

#: What program.py puts before every kind.
KIND_NEEDS = ["core/rng.h", "core/vector.h", "core/spectrum_1.h"]


def call(
    context: Context,
    concept: str,
    model: Any,
    record: Mapping[str, Any],
    body: str,
    results: list[str],
    inputs: Mapping[str, NDArray[np.generic]],
    lanes: int,
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
        parts=[*KIND_NEEDS, struct(values), f"{concept}/{model.kind}.h", numbers(values)],
        body=f"__constant const struct {name} *kind = &numbers;\n{body}",
    )


def numbers(record: Record) -> str:
    """A struct of constant memory, `numbers`."""
    return f"__constant struct {record.struct} numbers = {literal(record)};\n"


def struct(record: Record) -> str:
    members = " ".join(f"{ctype} {name};" for name, ctype in record.fields.items())
    return f"struct {record.struct} {{ {members} }};\n"


def literal(record: Record) -> str:
    """The struct's numbers as a C initialiser, exact: floats in hexadecimal."""
    parts = []
    for name, ctype in record.fields.items():
        value = np.asarray(record.values[name])
        if ctype == "int":
            parts.append(str(int(value)))
        elif value.ndim == 0 or ctype == "colour":
            parts.append(f"{float(np.float32(value.reshape(-1)[0])).hex()}f")
        else:
            parts.append("{" + ", ".join(f"{float(np.float32(v)).hex()}f" for v in value.reshape(-1)) + "}")
    return "{" + ", ".join(parts) + "}"
