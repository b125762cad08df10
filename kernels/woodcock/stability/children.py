"""Runs cases in a child process, because what they provoke may hang or take the process with it."""

from __future__ import annotations

import argparse
import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO

from woodcock import __version__
from woodcock.device import Device, find
from woodcock.stability.case import Case
from woodcock.stability.cases import CASES
from woodcock.stability.judging import Finding, failed
from woodcock.stability.outcome import Outcome, Row

#: A case that takes longer is taken to hang.
TIMEOUT_SECONDS = 60.0
#: A child that takes longer to begin has a driver that hangs.
START_SECONDS = 60.0
#: After so many cases in a row that killed their child the device is given up.
PATIENCE = 4

COMMAND = (sys.executable, "-m", "woodcock.stability")


def sweep(device: Device) -> Iterator[Row]:
    """Every case's row, as it is found; a case that hangs or crashes is one that failed."""
    return supervised(CASES, (*COMMAND, device.id), TIMEOUT_SECONDS)


def check(device: Device) -> Outcome:
    """The whole sweep of a device."""
    began = time.perf_counter()
    return outcome(device, list(sweep(device)), began)


def outcome(device: Device, rows: list[Row], began: float) -> Outcome:
    """began: by time.perf_counter."""
    return {
        "device": device.id,
        "name": device.name,
        "platform": device.platform,
        "driver": device.driver,
        "version": __version__,
        "passed": all(row["verdict"] != "failed" for row in rows),
        "seconds": time.perf_counter() - began,
        "rows": rows,
    }


def supervised(cases: Sequence[Case], command: Sequence[str], timeout: float) -> Iterator[Row]:
    """command: begins a child that `serve`s the same cases."""
    at, deaths = 0, 0
    while at < len(cases):
        for row in _child(cases, [*command, "--from", str(at)], at, timeout):
            yield row
            at += 1
            deaths = deaths + 1 if row["says"].startswith(ENDED) else 0
        if deaths >= PATIENCE and at < len(cases):
            for case in cases[at:]:
                yield _row(case, failed(f"not tried: {PATIENCE} cases in a row before it ended their process"), 0.0)
            return


#: How sentences of cases begin that took their child with them.
ENDED = "the case"


def _child(cases: Sequence[Case], command: list[str], at: int, timeout: float) -> Iterator[Row]:
    """Rows of one child, until it has served all cases or one has ended it."""
    with tempfile.TemporaryFile("w+") as errors:
        child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True)
        assert child.stdout is not None
        lines: queue.Queue[str | None] = queue.Queue()
        reader = threading.Thread(target=_pass_on, args=(child.stdout, lines), daemon=True)
        reader.start()
        ready = False
        try:
            while at < len(cases):
                began = time.perf_counter()
                try:
                    line = lines.get(timeout=timeout if ready else START_SECONDS)
                except queue.Empty:
                    yield _row(cases[at], failed(f"{ENDED} did not end within {timeout:g} s"), timeout)
                    return
                if line is None:
                    says = _last_words(child.wait(), errors)
                    yield _row(cases[at], failed(f"{ENDED} {says}"), time.perf_counter() - began)
                    return
                if not ready:
                    ready = True
                    continue
                row: Row = json.loads(line)
                yield row
                at += 1
        finally:
            child.kill()
            child.wait()
            reader.join()
            child.stdout.close()


def _pass_on(stream: IO[str], lines: queue.Queue[str | None]) -> None:
    for line in stream:
        lines.put(line)
    lines.put(None)


def _last_words(code: int, errors: IO[str]) -> str:
    """How a child died."""
    errors.seek(0)
    said = [line.strip() for line in errors if line.strip()]
    how = f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended its process with code {code}"
    return f"{how}: {said[-1] if said else 'no message'}"


def serve(cases: Sequence[Case], arguments: Sequence[str] | None = None) -> None:
    """The child: writes the row of one case after the other to stdout, a line of JSON each."""
    parser = argparse.ArgumentParser()
    parser.add_argument("device")
    parser.add_argument("--from", dest="first", type=int, default=0)
    asked = parser.parse_args(arguments)
    device = find(asked.device)
    # Drivers may write to stdout; that is no row.
    rows = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    print(file=rows, flush=True)  # ready
    for case in cases[asked.first :]:
        print(json.dumps(row_of(case, device)), file=rows, flush=True)


def row_of(case: Case, device: Device) -> Row:
    """Measures a case in this process; whatever it raises, it has failed."""
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        try:
            finding = case.measure(device, Path(folder))
        except Exception as error:
            said = str(error).splitlines()
            finding = failed(f"{type(error).__name__}: {said[0] if said else 'no message'}")
    return _row(case, finding, time.perf_counter() - began)


def _row(case: Case, finding: Finding, seconds: float) -> Row:
    return {
        "group": case.group,
        "case": case.name,
        "expected": finding.expected,
        "got": finding.got,
        "deviation": finding.deviation,
        "unit": finding.unit,
        "limit": finding.limit,
        "verdict": finding.verdict,
        "says": finding.says,
        "seconds": seconds,
    }
