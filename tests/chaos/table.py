"""The matrix as text: a row for each fault, a column for each stage."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from .faults import FAULTS
from .stages import STAGES

WORDS = {"passed": "survived", "failed": "**NOT**", "skipped": "cannot be tried here"}


def table(reports: Iterable[Any]) -> str:
    """Markdown, one table a database; numbers lead to why a cell is left out."""
    cells = {}
    for report in reports:
        cell = dict(report.user_properties)["cell"]
        if report.when == "call" or report.outcome != "passed":
            cells[tuple(cell)] = WORDS[report.outcome]
    lines, reasons = [], list[str]()
    for database in ("sqlite", "postgresql"):
        lines += ["", f"| {database} | {' | '.join(STAGES)} |", f"|{'---|' * (len(STAGES) + 1)}"]
        for fault in FAULTS:
            row = [fault.name]
            for stage in STAGES:
                if reason := fault.left_out.get(stage) or fault.left_out.get(database):
                    reasons += [reason] if reason not in reasons else []
                    row.append(f"– ({reasons.index(reason) + 1})")
                else:
                    row.append(cells.get((database, fault.name, stage), "not run"))
            lines.append(f"| {' | '.join(row)} |")
    lines += ["", *(f"({number}) {reason}" for number, reason in enumerate(reasons, 1))]
    return "\n".join(lines)
