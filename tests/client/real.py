"""The service itself, as a process, for tests of what people see of it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

PROGRAM = "import typer; from woodcock_server.command import serve; typer.run(serve)"


@dataclass(frozen=True)
class Gallery:
    """A service and two renders on it that have succeeded, of one scene with different seeds; data: its folder."""

    address: str
    data: Path
    renders: tuple[str, str]


@contextmanager
def serving(folder: Path, prelude: str = "") -> Iterator[str]:
    """The address of a service on a free port, which keeps its data in `folder/data`; prelude: Python that it runs
    before anything else."""
    command = [sys.executable, "-c", f"{prelude}\n{PROGRAM}", "--port", "0", "--data", str(folder / "data")]
    log = folder / "log"
    with log.open("wb") as output:
        process = subprocess.Popen(
            command,
            stdout=output,
            stderr=output,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "PYTHONUNBUFFERED": "1"},
            start_new_session=True,
        )
    try:
        deadline = time.monotonic() + 90
        while not (ready := re.search(r"is ready: (http://\S+?)/?\s", log.read_text())):
            assert process.poll() is None, log.read_text()
            assert time.monotonic() < deadline, log.read_text()
            time.sleep(0.1)
        yield ready[1]
        process.send_signal(signal.SIGINT)
        process.wait(timeout=30)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
