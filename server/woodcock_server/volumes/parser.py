"""Reads uploaded files, each in a child process: what a hostile file does to its reader happens there, within limits of
memory and time. It is no sandbox: the reader is the service's own code, and may do what the service may.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Generic, TypeVar

import structlog
from anyio import CapacityLimiter
from pydantic import BaseModel, ValidationError

from woodcock_server.volumes import contents
from woodcock_server.volumes.contents import UnreadableFile
from woodcock_server.volumes.samples import MOST_SAMPLES, Samples
from woodcock_server.volumes.schemas import Contents

T = TypeVar("T", bound=BaseModel)

log = structlog.get_logger()

#: Children at a time; together they take so many times the memory of one.
CHILDREN = 2
#: Most bytes of an answer; that of a volume of a hundred grids has ten thousand, and samples come as base64.
MOST_BYTES = 1 << 20
MOST_OF_SAMPLES = MOST_BYTES + 4 * MOST_SAMPLES // 3
#: Threads would take memory and processors for themselves.
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENIMAGEIO_THREADS": "1"}


class Answer(BaseModel, Generic[T]):
    """What a child writes: what the file holds, or a sentence for its sender; and what the log should say."""

    contents: T | None = None
    fault: str = ""
    error: str = ""


class Parser:
    """memory: bytes that reading one file may take; seconds: of a processor and of a clock. `turns`: who may read."""

    def __init__(self, memory: int, seconds: int) -> None:
        self.turns = CapacityLimiter(CHILDREN)
        self._memory = memory
        self._seconds = seconds

    def read(self, path: Path) -> Contents:
        """What a file holds; blocks. Raises UnreadableFile."""
        said, code, late = self._child(MOST_BYTES, str(path))
        if len(said) > MOST_BYTES and not late:
            raise UnreadableFile(f"holds grids whose names and sizes take more than {MOST_BYTES} bytes")
        return self._understood(Answer[Contents], said, code, late)

    def sample(self, path: Path, position: int) -> Samples:
        """Of the grid at this position of a volume; blocks. Raises UnreadableFile."""
        return self._understood(Answer[Samples], *self._child(MOST_OF_SAMPLES, str(path), str(position)))

    def _understood(self, kind: type[Answer[T]], said: bytes, code: int, late: bool) -> T:
        if late:
            raise UnreadableFile(f"takes more than {self._seconds} s to read, the most that a file may take here")
        try:
            answer = kind.model_validate_json(said)
        except ValidationError:
            how = f"by {signal.Signals(-code).name}" if code < 0 else f"with code {code}"
            answer = kind(fault=f"cannot be read: its reader ended {how}", error=f"it ended {how}")
        if answer.error:
            log.error("the reader of an uploaded file failed", error=answer.error)
        if answer.contents is None:
            raise UnreadableFile(answer.fault)
        return answer.contents

    def _child(self, most: int, path: str, *grid: str) -> tuple[bytes, int, bool]:
        """What it said, `most` bytes and one at most; its exit status, and whether its time ran out."""
        command = [sys.executable, "-m", contents.__name__, str(self._memory), str(self._seconds), path, *grid]
        began = time.monotonic()
        with subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **ONE_THREAD},
            start_new_session=True,  # Ctrl-C in the service's terminal says nothing of the file
        ) as child:
            assert child.stdout is not None
            end = threading.Timer(self._seconds, child.kill)
            end.start()
            try:
                said = child.stdout.read(most + 1)
                if len(said) <= most:
                    child.wait()
            finally:
                child.kill()
                end.cancel()
        late = child.returncode == -signal.SIGXCPU or time.monotonic() - began >= self._seconds
        return said, child.returncode, late and child.returncode != 0
