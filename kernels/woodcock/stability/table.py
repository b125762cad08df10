"""An outcome as a table for people."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from woodcock.stability.outcome import Row

STYLES = {"passed": "green", "failed": "bold red", "not expressible": "yellow"}
UNITS = {"standard errors": "σ", "roundings": "ε"}


def table(rows: Sequence[Row]) -> Table:
    """A line a case. `off` and `limit` count standard errors (σ) or roundings of float32 (ε, 2^-24 of what is
    expected); `left` is how much of the limit is."""
    result = Table("case", "expected", "got", "relative error", "off", "limit", "left", "verdict", box=SIMPLE_HEAD)
    for column in result.columns:
        column.no_wrap = True
    for column in result.columns[1:7]:
        column.justify = "right"
    group = None
    for row in rows:
        if row["group"] != group:
            group = row["group"]
            result.add_section()
            result.add_row(Text(group, style="bold"))
        numbers = map(_shown, (row["expected"], row["got"], relative_error(row)))
        mark = UNITS[row["unit"]]
        off, limit = row["deviation"], row["limit"]
        result.add_row(
            Text(f"  {row['case']}"),
            *numbers,
            f"{off:+.3g} {mark}" if off is not None else "",
            f"{limit:.3g} {mark}" if limit is not None else "",
            f"{max(0.0, 1 - abs(off) / limit):.0%}" if off is not None and limit else "",
            Text(row["verdict"], style=STYLES[row["verdict"]]),
        )
    return result


def sentences(rows: Sequence[Row]) -> list[str]:
    """What there is to say of cases, those that failed last."""
    said = sorted((row for row in rows if row["says"]), key=lambda row: row["verdict"] == "failed")
    return [f"{row['verdict']}: {row['group']}, {row['case']}: {row['says']}" for row in said]


def relative_error(row: Row) -> float | None:
    if row["expected"] is None or row["got"] is None or row["expected"] == 0:
        return None
    return (row["got"] - row["expected"]) / row["expected"]


def _shown(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"
