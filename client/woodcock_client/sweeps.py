"""What `woodcock submit` takes and shows of batches."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import NoReturn

from pydantic import JsonValue
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from woodcock_client.batch_models import Batch, BatchJob
from woodcock_client.models import State
from woodcock_client.progress import STEP
from woodcock_client.trials import PRINTED


def _refuse(constant: str) -> NoReturn:
    raise ValueError(constant)


#: Without NaN and infinities, which are no JSON.
JSON = json.JSONDecoder(parse_constant=_refuse)
#: States of which it is told how many jobs are in them.
SAID: tuple[State, ...] = ("running", "cancelling", "failed", "cancelled")


def axes(option: str, texts: Sequence[str]) -> dict[str, list[JsonValue]]:
    """`path=value,value` of every text. Raises ValueError with one sentence."""
    found = dict[str, list[JsonValue]]()
    for text in texts:
        path, equals, listed = text.partition("=")
        try:
            if not equals or path in found:
                raise ValueError
            found[path] = values(listed)
        except ValueError:
            right = "write each field once, as PATH=value,value, such as volumes[0].sigma_t=1,2,4"
            raise ValueError(f"{option} {text}: {right}") from None
    return found


def values(text: str) -> list[JsonValue]:
    """Values with commas between them: each as JSON where it is that, else as text. Raises ValueError."""
    found, start = list[JsonValue](), 0
    while True:
        value, end = _value(text, start)
        found.append(value)
        if end == len(text):
            return found
        start = end + 1


def _value(text: str, start: int) -> tuple[JsonValue, int]:
    """The value that begins there, and where it ends."""
    start += len(text[start:]) - len(text[start:].lstrip())
    try:
        value, end = JSON.raw_decode(text, start)
        end += len(text[end:]) - len(text[end:].lstrip())
        if text[end : end + 1] in ("", ","):
            return value, end
    except ValueError:
        pass
    end = text.find(",", start) if "," in text[start:] else len(text)
    if start == end or text[start] in '[{"':
        raise ValueError
    return text[start:end].rstrip(), end


def show(changes: Iterable[Batch]) -> Batch:
    """Follow a batch to its end, on standard error; the last of `changes`, which must hold one at least."""
    console = Console(stderr=True, highlight=False)
    return _bar(changes, console) if console.is_terminal else _lines(changes, console)


def _bar(changes: Iterable[Batch], console: Console) -> Batch:
    columns = TextColumn("{task.fields[state]}", markup=False), BarColumn(), TimeElapsedColumn()
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("", total=1.0, state="queued")
        for batch in changes:
            progress.update(task, completed=batch.fraction, state=_state(batch))
    return batch


def _lines(changes: Iterable[Batch], console: Console) -> Batch:
    shown: Batch | None = None
    for batch in changes:
        if shown is None or batch.finished or batch.fraction >= shown.fraction + STEP:
            shown = batch
            console.print(f"{batch.fraction:4.0%}, {_state(batch)}", markup=False, soft_wrap=True)
    return batch


def _state(batch: Batch) -> str:
    ended = sum(job.finished for job in batch.jobs)
    others = (f"{count} {state}" for state, count in batch.counts.items() if count and state in SAID)
    waiting = next((job.waiting for job in batch.jobs if job.waiting), None)
    return ", ".join(filter(None, [f"{ended} of {len(batch.jobs)} done", *others, waiting]))


def print_table(batch: Batch) -> None:
    """What came of every point."""
    console = Console(markup=False, highlight=False)
    if not console.is_terminal:
        console.width = PRINTED
    paths = [path for axis in batch.axes for path in axis.paths]
    table = Table(*paths, "state", "samples", "error", "seconds", box=SIMPLE_HEAD)
    table.add_column("render", no_wrap=True)
    for job in batch.jobs:
        table.add_row(*(_text(job.point.get(path)) for path in paths), *_cells(job))
    console.print(table)


def _cells(job: BatchJob) -> list[str]:
    error = "" if job.relative_rmse is None else f"{job.relative_rmse:.2%}"
    return [job.state, str(job.samples), error, f"{job.seconds:.1f}", job.id]


def _text(value: JsonValue) -> str:
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
