"""Local copies of objects that never change: those unused for longest make room."""

from __future__ import annotations

import fcntl
import math
import os
import threading
import time
from collections import Counter, OrderedDict, deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from woodcock.files import replacing

#: For so long what was asked for is being opened, seconds: it stays.
GRACE = 600.0
#: The same of what was dropped.
GRACE_DROPPED = 10.0


class Copies:
    """A folder of one process's own. room: bytes that the copies may take; what is held, or was asked for within GRACE,
    stays beyond it.

    Raises OSError where another process has the folder.
    """

    def __init__(self, folder: Path, room: int) -> None:
        self._folder, self._room = folder, room
        folder.mkdir(parents=True, exist_ok=True)
        self._mine = os.open(folder / ".lock", os.O_CREAT | os.O_RDWR)  # for as long as the process lives
        try:
            fcntl.flock(self._mine, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(self._mine)
            raise OSError(error.errno, "another service uses it, and with an object store each has its own") from None
        self._lock = threading.Lock()
        self._turns = dict[str, threading.Lock]()
        self._held = Counter[str]()
        self._dropped = deque[tuple[float, str]]()  # when they go, and their names
        self._known = OrderedDict[str, tuple[int, float]]()  # name -> bytes, and when it was asked for; oldest first
        for path in folder.glob(".[!l]*"):  # what was being fetched
            path.unlink()
        found = [(path, path.stat()) for path in folder.glob("[!.]*")]
        for path, status in sorted(found, key=lambda each: each[1].st_mtime):
            self._known[path.name] = status.st_size, -math.inf
        self._taken = sum(size for size, _ in self._known.values())

    def close(self) -> None:
        """Let another process have the folder."""
        os.close(self._mine)

    def path(self, key: str) -> Path:
        """Where the copy is, if there is one."""
        return self._folder / key.replace("/", "-")

    def get(self, key: str, fetch: Callable[[Path], object]) -> Path:
        """The copy, made by `fetch` if there is none. Raises OSError, and what that raises."""
        path = self.path(key)
        with self._lock:
            turn = self._turns.setdefault(path.name, threading.Lock())
        with turn:
            if path.name not in self._known:
                with replacing(path) as temporary:
                    fetch(temporary)
            self._note(path)
        return path

    def adopt(self, key: str, made: Path) -> None:
        """A file that is in the store becomes the copy. Raises OSError."""
        made.replace(self.path(key))
        self._note(self.path(key))

    def drop(self, key: str) -> None:
        """The object is no more, and nobody asks for it again."""
        with self._lock:
            self._dropped.append((time.monotonic() + GRACE_DROPPED, self.path(key).name))

    @contextmanager
    def holding(self, keys: list[str]) -> Iterator[None]:
        """What is got meanwhile of these stays."""
        names = [self.path(key).name for key in keys]
        with self._lock:
            self._held.update(names)
        try:
            yield
        finally:
            with self._lock:
                self._held -= Counter(names)

    def _note(self, path: Path) -> None:
        """It was asked for; what is too much goes."""
        now = time.monotonic()
        with self._lock:
            os.utime(path)
            size, _ = self._known.pop(path.name, (0, now))
            self._known[path.name] = path.stat().st_size, now
            self._taken += self._known[path.name][0] - size
            while self._dropped and self._dropped[0][0] < now:
                self._forget(self._dropped.popleft()[1])
            for name, (_, used) in list(self._known.items()):
                if self._taken <= self._room or used > now - GRACE:
                    break
                if not self._held[name]:
                    self._forget(name)

    def _forget(self, name: str) -> None:
        (self._folder / name).unlink(missing_ok=True)
        self._turns.pop(name, None)
        self._taken -= self._known.pop(name, (0, 0.0))[0]
