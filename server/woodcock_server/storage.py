"""Files the service keeps: uploads by their content, a folder for each job. Nothing half-written bears a final name.

They are kept in the data folder, or in a bucket (bucket.py).
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from woodcock.files import replacing
from woodcock.scene import UPLOADED

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from woodcock_server.store import Store

#: Key of what is written to find out whether anything can be.
PROBE = "probe"
_CHECKPOINT = re.compile(r"film-(\d+)\.npz")


class StoreAway(Exception):  # noqa: N818 - it says what happened
    """The object store does not answer, or refuses; it may again."""

    def __init__(self, says: str = "The object store does not answer; the server's log says why.") -> None:
        super().__init__(says)


class NoStore(Exception):  # noqa: N818 - it says what is missing
    """No object store can be used by that URL."""

    def __init__(self, url: str, reason: str) -> None:
        super().__init__(f"The object store {url} cannot be used: {reason}.")


class Collected(Exception):  # noqa: N818 - it says what happened
    """The file was deleted while it was brought once more."""


class Upload:
    """A file on its way in: bytes are hashed while they go to a temporary file."""

    def __init__(self, stream: BinaryIO, path: Path) -> None:
        self.path = path
        self.size = 0
        self._stream = stream
        self._hash = hashlib.sha256()

    def write(self, chunk: bytes) -> None:
        """Append. Raises OSError."""
        self._stream.write(chunk)
        self._hash.update(chunk)
        self.size += len(chunk)

    def finish(self) -> str:
        """Bring the bytes to the disk; returns their SHA-256, 64 hex digits. Raises OSError."""
        self._stream.flush()
        os.fsync(self._stream.fileno())
        return self._hash.hexdigest()


class Storage:
    """The data folder. Methods block; call them from a thread. Where a bucket keeps the files all but those of which it
    is said otherwise raise StoreAway too."""

    def __init__(self, root: Path, kept: Path | None = None) -> None:
        """kept: where volumes and jobs are, if not in the root."""
        self.root = root
        self.volumes = (kept or root) / "volumes"
        self.jobs = (kept or root) / "jobs"
        self.scratch = root / "scratch"
        for folder in (self.volumes, self.jobs, self.scratch):
            folder.mkdir(parents=True, exist_ok=True)
        # Uploads that a killed server was receiving; another server's may be younger.
        for folder in self.scratch.glob("upload-*"):
            with suppress(FileNotFoundError):
                if max(path.stat().st_mtime for path in (folder, *folder.iterdir())) < time.time() - 86400:
                    shutil.rmtree(folder, ignore_errors=True)
        for path in self.scratch.glob("gone-*"):
            shutil.rmtree(path, ignore_errors=True)

    def close(self) -> None:
        """Let others have the folder, where it is one's own."""

    def try_writing(self) -> None:
        """Raises OSError where nothing can be written, for rights, room or a fault."""
        with tempfile.TemporaryFile(dir=self.scratch) as file:
            file.write(bytes(4096))

    # Volumes

    @contextmanager
    def upload(self) -> Iterator[Upload]:
        """A place for a file's bytes; gone afterwards, unless kept. It is alone in its folder, for a file may name its
        neighbours, and does not know its own name."""
        with tempfile.TemporaryDirectory(prefix="upload-", dir=self.scratch) as folder:
            handle, name = tempfile.mkstemp(dir=folder)
            with os.fdopen(handle, "wb") as stream:
                yield Upload(stream, Path(name))

    @contextmanager
    def bringing_volume(self, upload: Path, volume_id: str) -> Iterator[Callable[[], None]]:
        """Bring an uploaded file to its name for good. What is yielded does so, while the row is being written, and
        raises OSError, Collected."""

        def keep() -> None:
            upload.replace(self.volume_file(volume_id))
            _sync_folder(self.volumes)

        yield keep

    def has_volume(self, volume_id: str) -> bool:
        return self.volume_file(volume_id).exists()

    def volume_file(self, volume_id: str) -> Path:
        """Where the file `sha256:<64 hex>` lies, for now."""
        return self.volumes / volume_id.removeprefix(UPLOADED)

    @contextmanager
    def volume_files(self, volume_ids: Iterable[str]) -> Iterator[dict[str, Path]]:
        """Where these files lie, for as long as the block takes."""
        yield {each: self.volume_file(each) for each in volume_ids}

    def volume_source(self, volume_id: str) -> tuple[int, str | None]:
        """Bytes of a file, and a URL by which anybody can read it for a while, if there is one. Raises OSError."""
        return self.volume_file(volume_id).stat().st_size, None

    def read_volume(self, volume_id: str, offset: int, length: int) -> bytes:
        """Part of a file, less at its end. Raises OSError."""
        with self.volume_file(volume_id).open("rb") as file:
            file.seek(offset)
            return file.read(length)

    def drop_volume(self, volume_id: str) -> None:
        """While its row is locked. Raises OSError."""
        self.volume_file(volume_id).unlink(missing_ok=True)

    def by_id(self, sentence: str) -> str:
        """The sentence with uploaded files' ids in place of their paths, which are nobody's business."""
        return sentence.replace(f"{self.volumes}{os.sep}", UPLOADED).replace(f"{self.root}{os.sep}", "")

    # Jobs

    def job_file(self, job_id: str, name: str) -> Path:
        """Where it lies for now; nothing is there if the job has none."""
        return self.jobs / job_id / name

    def open_job(self, job_id: str) -> None:
        """Make the job's folder, and rid it of what a killed holder was writing. Does not raise StoreAway."""
        folder = self.jobs / job_id
        folder.mkdir(exist_ok=True)
        for path in folder.glob(".*"):
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)

    def stage(self, job_id: str, token: int) -> Path:
        """Make a folder for what the holder of this token makes, until it is published or not wanted any more. Raises
        OSError, not StoreAway."""
        folder = self._staged(job_id, token)
        folder.mkdir(exist_ok=True)
        return folder

    @contextmanager
    def publishing(self, job_id: str, token: int) -> Iterator[Callable[[Connection], None]]:
        """Put the files that are staged into the job's folder. What is yielded does so, while the row is locked; it is
        not called where another holds the job. Raises OSError."""

        def publish(_: Connection) -> None:
            for path in self._made(job_id, token):
                path.replace(self.jobs / job_id / path.name)

        yield publish
        self.unstage(job_id, token)

    def unstage(self, job_id: str, token: int) -> None:
        """Does not raise."""
        shutil.rmtree(self._staged(job_id, token), ignore_errors=True)

    def _staged(self, job_id: str, token: int) -> Path:
        return self.jobs / job_id / f".{token}"

    def _made(self, job_id: str, token: int) -> list[Path]:
        """What is staged and whole."""
        return [path for path in self._staged(job_id, token).iterdir() if not path.name.startswith(".")]

    def remove_job(self, job_id: str) -> None:
        """Its folder, under another name first: what is half removed is no job's. Does not raise StoreAway."""
        gone = self.scratch / f"gone-{job_id}"
        with suppress(FileNotFoundError):
            (self.jobs / job_id).rename(gone)
        shutil.rmtree(gone, ignore_errors=True)

    def size(self, job_id: str) -> int:
        """Of its files, bytes."""
        total = 0
        with suppress(FileNotFoundError):  # It is being removed.
            for path in (self.jobs / job_id).iterdir():
                total += path.stat().st_size
        return total

    def folders(self) -> set[str]:
        """Ids of what has one."""
        return {path.name for path in self.jobs.iterdir()}

    def write_text(self, job_id: str, name: str, text: str) -> None:
        """Into a folder that is opened, for good. Raises OSError."""
        write_text(self.jobs / job_id / name, text)

    def newest_checkpoint(self, job_id: str) -> Path | None:
        """The Film of the latest holder that wrote one. Raises OSError."""
        return max(self._checkpoints(job_id), key=lambda path: token_of(path.name), default=None)

    def drop_checkpoints(self, job_id: str, before: int) -> None:
        """Remove the Films of holders before this token. Does not raise StoreAway."""
        for path in self._checkpoints(job_id):
            if token_of(path.name) < before:
                path.unlink(missing_ok=True)

    def hand_on(self, old: str, new: str) -> bool:
        """Let a job that has not begun find the Film of another one, and its pictures; False if that has none."""
        film = self.newest_checkpoint(old)
        if film is None:
            return False
        self.open_job(new)
        # None is ever written to, only replaced.
        self.job_file(new, film_name(0)).hardlink_to(film)
        self.job_file(new, "preview.png").hardlink_to(self.job_file(old, "preview.png"))
        with suppress(FileNotFoundError):  # It ended under a version that wrote none.
            self.job_file(new, "thumbnail.webp").hardlink_to(self.job_file(old, "thumbnail.webp"))
        return True

    def _checkpoints(self, job_id: str) -> list[Path]:
        with suppress(FileNotFoundError):
            return [path for path in (self.jobs / job_id).iterdir() if token_of(path.name) >= 0]
        return []

    def collect(self) -> None:
        """Remove what nothing names, and was left by a server that was killed: here that is done at the start."""


def open_store(url: str) -> Store:
    """The bucket of a URL; nothing is asked of it yet. Raises NoStore."""
    try:
        from woodcock_server.store import connect  # what not every installation has
    except ImportError:
        raise NoStore(url, "its client is not installed: pip install 'woodcock[s3]'") from None
    return connect(url)


def film_name(token: int) -> str:
    """Under which the holder of this token keeps the job's Film: no two holders share a file."""
    return f"film-{token}.npz"


def token_of(name: str) -> int:
    """Of a Film's file; -1 for another one."""
    match = _CHECKPOINT.fullmatch(name)
    return int(match[1]) if match else -1


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Raises OSError, and ValueError for NaN and infinities."""
    write_text(path, as_json(content))


def as_json(content: dict[str, Any]) -> str:
    """Raises ValueError for NaN and infinities."""
    return json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def write_text(path: Path, text: str) -> None:
    """Raises OSError."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _sync_folder(folder: Path) -> None:
    """A rename is durable once its folder is."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
