"""What `woodcock submit` shows of dry runs and of comparisons."""

from __future__ import annotations

import time
from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from woodcock_client.client import Client
from woodcock_client.trial_models import Comparison, DeviceForecast, JobCheck

#: Columns of a table that goes to no terminal.
PRINTED = 160
#: Between two looks at a comparison, seconds.
LOOK_EVERY = 1.0


def choices(texts: Sequence[str]) -> dict[str, list[str]]:
    """`field=kind,kind` of every text. Raises ValueError with one sentence."""
    vary: dict[str, list[str]] = {}
    for text in texts:
        field, equals, kinds = text.partition("=")
        if not equals or not all(kinds.split(",")) or field in vary:
            raise ValueError(f"--vary {text}: write each field once, as FIELD=kind,kind, such as majorant=global,grid")
        vary[field] = kinds.split(",")
    return vary


def print_check(check: JobCheck) -> None:
    """A table of devices, then what they would compile and hold."""
    console = Console()
    if not console.is_terminal:
        console.width = PRINTED
    table = Table(
        "device", "fits", "renders for", "95 % interval", "samples", "error", "read and build", box=SIMPLE_HEAD
    )
    for device in check.devices:
        table.add_row(*_cells(device))
    console.print(table)
    for device in check.devices:
        for said in filter(None, (device.reason, device.says)):
            console.print(f"{device.id}: {said}", highlight=False, soft_wrap=True)
    if check.program is not None:
        state = "built before" if check.program.built else "not built before"
        console.print(
            f"program {check.program.hash[:12]}: {check.program.source_lines} lines in {check.program.lanes} lanes, "
            f"{len(check.program.left_out)} files left out, {state}",
            highlight=False,
        )
    if check.memory is not None:
        there, here = (size / 2**20 for size in (check.memory.device, check.memory.host))
        console.print(f"memory: {there:.1f} MiB on the device, {here:.1f} MiB on the host", highlight=False)


def _cells(device: DeviceForecast) -> list[str]:
    seconds, high = _duration(device.seconds), _duration(device.high)
    spent = (device.read_seconds or 0.0) + (device.build_seconds or 0.0)
    return [
        device.id,
        {True: "yes", False: "no", None: "not known"}[device.fits],
        seconds,
        f"{_duration(device.low)} to {high or 'no bound'}" if device.low is not None else "",
        "" if device.samples is None else f"{device.samples:.4g}",
        "" if device.error is None else f"{device.error:.2%}",
        "" if device.build_seconds is None else _duration(spent),
    ]


def _duration(seconds: float | None) -> str:
    if seconds is None:
        return ""
    return (
        f"{seconds:.3g} s"
        if seconds < 600
        else f"{seconds / 60:.3g} min"
        if seconds < 36000
        else f"{seconds / 3600:.3g} h"
    )


def wait(client: Client, comparison: Comparison) -> Comparison:
    """The comparison once all of its jobs have ended."""
    while not comparison.finished:
        time.sleep(LOOK_EVERY)
        comparison = client.comparison(comparison.id)
    return comparison
