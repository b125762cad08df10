"""Uploaded files on a worker host, shared by its worker processes: fetched once, by their content, and kept up to so
many bytes."""

from __future__ import annotations

import fcntl
import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, Protocol

from woodcock.device import DeviceError
from woodcock.formats import VolumeError
from woodcock.scene import UPLOADED


class NoRoomError(DeviceError):
    """The files that are in use leave too little."""


class Source(Protocol):
    """Where files come from. Methods raise OSError."""

    def size(self, file_id: str) -> int:
        """Bytes."""

    def chunks(self, file_id: str) -> Iterator[bytes]:
        """Its content, in order."""


class Held:
    """A file that stays in the cache for as long as this object is there; its process may be killed."""

    def __init__(self, path: Path, stream: BinaryIO) -> None:
        self.path, self._stream = path, stream

    def __del__(self) -> None:
        self._stream.close()


class Cache:
    """A folder of files named by the SHA-256 of their content. What nobody has held for longest goes first."""

    def __init__(self, folder: Path, limit: int) -> None:
        """limit: bytes."""
        self._folder, self._limit = folder, limit

    def fetch(self, file_id: str, source: Source) -> Held:
        """The file `sha256:<64 hex>`, one process at a time, so that it is fetched once.

        Raises NoRoomError, VolumeError for one whose content is another, and OSError.
        """
        path = self._folder / file_id.removeprefix(UPLOADED)
        with self._alone():
            if not path.exists():
                self._make_room(source.size(file_id), file_id)
                self._receive(path, source.chunks(file_id))
            os.utime(path)
            stream = path.open("rb")
            fcntl.flock(stream, fcntl.LOCK_SH)
        return Held(path, stream)

    def by_id(self, sentence: str) -> str:
        """The sentence with files' ids in place of their paths."""
        return sentence.replace(f"{self._folder}{os.sep}", UPLOADED)

    @contextmanager
    def _alone(self) -> Iterator[None]:
        self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        with (self._folder / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield

    def _make_room(self, size: int, file_id: str) -> None:
        """Remove files that nobody holds, and what a killed process left, until so many bytes more fit."""
        for part in self._folder.glob("*.part"):
            part.unlink()
        kept = [(path, path.stat()) for path in self._folder.iterdir() if path.name != "lock"]
        left = self._limit - size - sum(stat.st_size for _, stat in kept)
        for path, stat in sorted(kept, key=lambda each: each[1].st_mtime_ns):
            if left >= 0:
                return
            with path.open("rb") as stream, suppress(BlockingIOError):
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
                path.unlink()
                left += stat.st_size
        if left < 0:
            raise NoRoomError(
                f"{file_id} takes {size >> 20} MiB, for which this host's cache has no room beside what is in use; "
                f"WOODCOCK_CACHE_SIZE is {self._limit >> 20} MiB"
            )

    def _receive(self, path: Path, chunks: Iterator[bytes]) -> None:
        part, digest = path.with_suffix(".part"), hashlib.sha256()
        try:
            with part.open("wb") as stream:
                for chunk in chunks:
                    stream.write(chunk)
                    digest.update(chunk)
                stream.flush()
                os.fsync(stream.fileno())
            if digest.hexdigest() != path.name:
                raise VolumeError(f"{UPLOADED}{path.name}: what came has another content")
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
