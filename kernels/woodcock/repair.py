"""Progressive repair: a majorant that tracking found too low is raised, and the launch that found it rendered again.

A majorant below σ_t is a bias. Bounds are computed from what is stored, so that none should be; where one is
nevertheless, the largest σ_t / majorant of a launch says by how much at least. Misso et al., "Progressive null-tracking
for volumetric rendering", SIGGRAPH 2023, raise the bound for the samples to come and stay consistent: what an excess
that is not yet found leaves vanishes as samples grow. Here the samples that found it are not kept either.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from woodcock.layout import Layout, Record
from woodcock.majorant.grid import blocks_of, with_blocks

#: Of what was found, so that values a little higher need no other round.
MARGIN = 1.01

#: Launches in a row that are rendered again at most; the last is kept, with its violations.
MOST_ROUNDS = 8


def raised(layout: Layout, excess: float) -> Layout:
    """The same scene under a majorant higher by a little more than `excess`; its program is the same.

    Where a bound was wrong the controls are not trusted either: they become 0, and the residual the whole majorant.
    """
    factor = excess * MARGIN
    records = layout.records
    if any(record.struct == "majorant_global" for record in records):
        records = tuple(_raised(record, factor) for record in records)
    buffers = dict(layout.buffers)
    for name, array in layout.buffers.items():
        if not is_bound(name):
            continue
        values = _values(array)
        if name.startswith("minorant_"):
            buffers[name] = np.zeros_like(values)
        else:
            buffers[name] = with_blocks(values * np.float32(factor), blocks_of(values))
    if "majorant_residual" in buffers:
        buffers["majorant_residual"] = buffers.get("majorant_grid_bounds", _of_all(records))
    return replace(layout, records=records, buffers=buffers)


def is_bound(name: str) -> bool:
    """Whether a buffer holds bounds, from above or below."""
    return name.startswith(("majorant_", "minorant_"))


def _of_all(records: Iterable[Record]) -> NDArray[np.float32]:
    """(1,): the one majorant of the whole volume."""
    found = next(
        (record.values for record in records if record.struct == "majorant_global"), {"mean_free_path": np.inf}
    )
    return np.array([1 / found["mean_free_path"]], np.float32)


def _raised(record: Record, factor: float) -> Record:
    # The small loop's densities are relative to its one majorant.
    shrinking = {"majorant_global": "mean_free_path", "volume_grid": "relative"}.get(record.struct)
    if shrinking is None:
        return record
    values: Mapping[str, Any] = {**record.values, shrinking: record.values[shrinking] / factor}
    return replace(record, values=values)


def _values(array: Any) -> NDArray[np.float32]:
    values: NDArray[np.float32] = array.array() if hasattr(array, "pieces") else array
    return values
