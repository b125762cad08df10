"""The command line's `stability`."""

from __future__ import annotations

import json
import time
from collections import Counter
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from woodcock.device import DeviceError, find
from woodcock.stability.cases import CASES
from woodcock.stability.children import outcome, sweep
from woodcock.stability.outcome import Row
from woodcock.stability.table import sentences, table

FAILED, BAD_INPUT = 1, 2

#: Characters that the table takes at least; a narrower terminal wraps it.
WIDTH = 190


def stability(
    device: Annotated[str | None, typer.Option(metavar="ID", help="Device, by its id in `woodcock devices`.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the outcome as JSON.")] = False,
) -> None:
    """Check a device on stiff and extreme scenes, each against its exact answer.

    \b
      woodcock stability
      woodcock stability --device gpu0 --json > gpu0.json

    Prints how far every case is off, in standard errors (σ) where it is solved by random paths, else in roundings of
    float32 (ε). Exit codes: 0 every case passed, 1 one failed, 2 bad usage.
    """
    try:
        found = find(device)
    except DeviceError as error:
        typer.echo(f"woodcock: {error}", err=True)
        raise SystemExit(BAD_INPUT if device else FAILED) from None
    began, rows = time.perf_counter(), list[Row]()
    columns = (BarColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("", total=len(CASES))
        for row in sweep(found):
            rows.append(row)
            progress.update(task, advance=1, description=f"{row['group']}: {row['case']}")
    result = outcome(found, rows, began)
    if as_json:
        typer.echo(json.dumps(result, indent=2, ensure_ascii=False))
    else:
        counts = Counter(row["verdict"] for row in rows)
        Console(width=max(Console().width, WIDTH)).print(table(rows))
        typer.echo("\n".join([*sentences(rows), ""]))
        typer.echo(
            f"{found.id} ({found.name}): {', '.join(f'{count} {verdict}' for verdict, count in counts.items())} "
            f"in {result['seconds']:.0f} s"
        )
    if not result["passed"]:
        raise SystemExit(FAILED)
