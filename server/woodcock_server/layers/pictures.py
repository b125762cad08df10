"""The pictures of jobs, as channels: of a finished one from its EXR, of one that is rendered from its checkpoint."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from anyio import CapacityLimiter
from fastapi import HTTPException
from numpy.typing import NDArray

from woodcock.film import Film, FilmError
from woodcock.image import ImageError, measured, read_rows, shape_of
from woodcock_server.jobs.states import State
from woodcock_server.layers.cache import Cache, Channels
from woodcock_server.storage import Storage

#: Bytes of channels that are kept for the next question.
KEPT = 256 << 20
#: Largest checkpoint that is read for a look at it, bytes: a tenth of a second, and not much beside what renders it.
LARGEST_FILM = 1 << 30
#: Rows that an EXR packs together: none is read alone.
STRIP = 16
#: Checkpoints take one another's place while they are looked for.
TRIES = 3


class Unseen(HTTPException):
    """A 404: the job is there, its layers are not."""

    def __init__(self, row: Mapping[str, Any], why: str) -> None:
        super().__init__(404, f"Job {row['id']} has no layers: {why}.")


class Picture(ABC):
    """names: of its channels, as in an EXR; samples: of a pixel that has all of them; tag: changes when it does."""

    names: tuple[str, ...]
    width: int
    height: int
    samples: int
    tag: str

    @abstractmethod
    def channels(self, names: Sequence[str]) -> NDArray[np.float32]:
        """(height, width, names). Raises ImageError."""

    @abstractmethod
    def strips(self, start: int, stop: int) -> Iterator[Channels]:
        """All channels of rows [start, stop), a few rows at a time (rows, width). Raises ImageError."""


class Finished(Picture):
    """Read as far as it is asked for: an EXR may be larger than memory."""

    def __init__(self, path: Path, samples: int, cache: Cache) -> None:
        """Raises ImageError, OSError."""
        self.names, self.width, self.height = shape_of(path)
        self.samples = samples
        self.tag = _identity(path)
        self._path = path
        self._cache = cache

    def channels(self, names: Sequence[str]) -> NDArray[np.float32]:
        return np.stack(list(read_rows(self._path, 0, self.height, names).values()), axis=-1)

    def strips(self, start: int, stop: int) -> Iterator[Channels]:
        for first in range(start - start % STRIP, stop, STRIP):
            last = min(first + STRIP, self.height)
            strip = self._cache.get((self.tag, first), lambda: read_rows(self._path, first, last, self.names))  # noqa: B023
            yield {name: rows[max(start - first, 0) : stop - first] for name, rows in strip.items()}


class Running(Picture):
    """As it was at a checkpoint."""

    def __init__(self, path: Path, cache: Cache) -> None:
        """Raises FilmError, OSError."""
        self.tag = _identity(path)
        self._channels = cache.get(self.tag, lambda: _of_film(path))
        count = self._channels["samples.count"]
        self.names = tuple(self._channels)
        self.height, self.width = count.shape
        self.samples = int(count.max())

    def channels(self, names: Sequence[str]) -> NDArray[np.float32]:
        return np.stack([self._channels[name] for name in names], axis=-1)

    def strips(self, start: int, stop: int) -> Iterator[Channels]:
        yield {name: values[start:stop] for name, values in self._channels.items()}


class Pictures:
    """`turns`: who may read: what is read at a time stays bounded."""

    def __init__(self, storage: Storage) -> None:
        self.turns = CapacityLimiter(2)
        self._storage = storage
        self._cache = Cache(KEPT)

    def of(self, row: Mapping[str, Any]) -> Picture:
        """A job's picture as it is now; blocks. Raises Unseen."""
        state = State(row["state"])
        if state is State.SUCCEEDED:
            try:
                return Finished(self._storage.job_file(row["id"], "image.exr"), row["samples"], self._cache)
            except (ImageError, OSError):
                raise Unseen(row, "its image.exr was deleted or cannot be read") from None
        for _ in range(TRIES):
            path = self._storage.newest_checkpoint(row["id"])
            if path is None:
                break
            try:
                if path.stat().st_size > LARGEST_FILM:
                    raise Unseen(row, f"it is {state}, and too large to be looked at before it is done")
                return Running(path, self._cache)
            except (FilmError, OSError):
                continue
        raise Unseen(row, f"it is {state}" if state.final else f"it is {state}, and nothing was kept of it yet")


def _of_film(path: Path) -> Channels:
    with np.errstate(over="ignore"):  # as in an EXR: what float32 cannot hold is infinite
        return {name: values.astype(np.float32) for name, values in measured(Film.load(path)).items()}


def _identity(path: Path) -> str:
    """Of a file that is replaced but never written to."""
    found = path.stat()
    return f"{found.st_dev:x}-{found.st_ino:x}-{found.st_mtime_ns:x}-{found.st_size:x}"
