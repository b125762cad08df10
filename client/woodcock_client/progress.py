"""A job's progress on a terminal, or as plain lines where there is none."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from woodcock.scene import RelativeErrorStop, SamplesStop
from woodcock_client.models import JobSummary

STEP = 0.1  # of the way to the target, between plain lines


def show(changes: Iterable[JobSummary], *, quiet: bool = False) -> JobSummary:
    """Follow a job to its end, on standard error; the last of `changes`, which must hold one at least."""
    console = Console(stderr=True, highlight=False)
    if quiet:
        *_, last = changes
        return last
    return _bar(changes, console) if console.is_terminal else _lines(changes, console)


def _bar(changes: Iterable[JobSummary], console: Console) -> JobSummary:
    columns = (
        TextColumn("{task.fields[state]}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[samples]}", markup=False),
        TextColumn("{task.fields[error]}", markup=False),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("", total=1.0, state="queued", samples="", error="")
        for job in changes:
            said = job.waiting or error(job)
            progress.update(task, completed=job.fraction, state=job.state, samples=samples(job), error=said)
    return job


def _lines(changes: Iterable[JobSummary], console: Console) -> JobSummary:
    shown: JobSummary | None = None
    for job in changes:
        known = shown and (shown.state, shown.waiting)
        if shown is None or (job.state, job.waiting) != known or job.fraction >= shown.fraction + STEP:
            shown = job
            said = job.waiting or error(job)
            parts = (f"{job.state:<9} {job.fraction:4.0%}", samples(job), said, f"{job.seconds:.1f} s")
            console.print(", ".join(part for part in parts if part), markup=False, soft_wrap=True)
    return job


def samples(job: JobSummary) -> str:
    """Samples per pixel, against the target where the target counts them."""
    if isinstance(job.target, SamplesStop):
        return f"{job.samples} / {job.target.samples} samples"
    if isinstance(job.target, RelativeErrorStop):
        return f"{job.samples} samples to an error of {job.target.relative_error:.2%}"
    return f"{job.samples} samples in {job.seconds:.1f} / {job.target.seconds:g} s"


def error(job: JobSummary) -> str:
    """The estimated error, relative to the picture's mean where that is known; empty before it can be estimated.

    What it is at most, where there is no noise.
    """
    if job.deterministic and job.rmse is not None:
        relative = job.relative_rmse
        return "no noise, error at most " + (f"{job.rmse:.1g}" if relative is None else f"{100 * relative:.1g}%")
    if job.relative_rmse is not None:
        return f"error {job.relative_rmse:.2%}"
    return "" if job.rmse is None else f"error {job.rmse:.3g}"
