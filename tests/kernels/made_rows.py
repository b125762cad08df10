"""Rows of comparisons that were never made."""

from __future__ import annotations

import numpy as np

from woodcock.compare import Row, Slice
from woodcock.compare.agreement import Mean
from woodcock.compare.efficiency import efficiency


def part(value: float, error: float = 0.01, bound: float = 0.0) -> list[Mean]:
    return [Mean(value, error, bound)]


def entry(label: str, speed: float, *, mean: float = 1.0, deterministic: bool = False, turns: int = 10) -> Row:
    """A row whose turns differ by a few per cent; speed: its efficiency."""
    times = 1 / speed * (1 + 0.03 * np.sin(np.arange(turns) * (1 + len(label))))
    found = [] if deterministic else [Slice(float(t), 4, 4.0) for t in times]
    return {
        "label": label,
        "choices": {"majorant": label},
        "default": False,
        "seconds": float(times.sum()),
        "build_seconds": 0.1,
        "samples": 4.0 * turns,
        "rmse": 0.1,
        "deterministic": deterministic,
        "efficiency": None if deterministic else efficiency(found),
        "slices": found,
        "means": part(mean, 0.0 if deterministic else 0.01, 1e-3 if deterministic else 0.0),
        "against": None,
        "series": [],
    }
