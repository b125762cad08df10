"""Files the service keeps: uploads by their content, a folder for each job. Nothing half-written bears a final name."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

from woodcock.files import replacing
from woodcock.scene import UPLOADED

_CHECKPOINT = re.compile(r"film-(\d+)\.npz")


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
    """The data folder. Methods block; call them from a thread."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.volumes = root / "volumes"
        self.jobs = root / "jobs"
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

    def keep_volume(self, upload: Path, volume_id: str) -> None:
        """Move an uploaded file to its name for good. Raises OSError."""
        upload.replace(self.volume_file(volume_id))
        _sync_folder(self.volumes)

    def volume_file(self, volume_id: str) -> Path:
        """Where the file `sha256:<64 hex>` lies."""
        return self.volumes / volume_id.removeprefix(UPLOADED)

    def by_id(self, sentence: str) -> str:
        """The sentence with uploaded files' ids in place of their paths, which are nobody's business."""
        return sentence.replace(f"{self.volumes}{os.sep}", UPLOADED).replace(f"{self.root}{os.sep}", "")

    # Jobs

    def job_file(self, job_id: str, name: str) -> Path:
        return self.jobs / job_id / name

    def open_job(self, job_id: str) -> None:
        """Make the job's folder, and rid it of what a killed holder was writing."""
        folder = self.jobs / job_id
        folder.mkdir(exist_ok=True)
        for path in folder.glob(".*"):
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)

    def stage(self, job_id: str, token: int) -> str:
        """Make a folder for what the holder of this token makes, until it is published or not wanted any more; to be
        given in place of the job's id."""
        staged = f"{job_id}/.{token}"
        (self.jobs / staged).mkdir(exist_ok=True)
        return staged

    def publish(self, job_id: str, token: int) -> None:
        """Put the files that are staged into the job's folder. Raises OSError."""
        for path in self.job_file(job_id, f".{token}").iterdir():
            if not path.name.startswith("."):
                path.replace(self.job_file(job_id, path.name))
        self.unstage(job_id, token)

    def unstage(self, job_id: str, token: int) -> None:
        shutil.rmtree(self.job_file(job_id, f".{token}"), ignore_errors=True)

    def remove_job(self, job_id: str) -> None:
        """Its folder, under another name first: what is half removed is no job's."""
        gone = self.scratch / f"gone-{job_id}"
        with suppress(FileNotFoundError):
            self.job_file(job_id, "").rename(gone)
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

    def write_json(self, job_id: str, name: str, content: dict[str, Any]) -> None:
        """Raises OSError, and ValueError for NaN and infinities."""
        self.write_text(job_id, name, json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False) + "\n")

    def write_text(self, job_id: str, name: str, text: str) -> None:
        """Raises OSError."""
        with replacing(self.job_file(job_id, name)) as path:
            path.write_text(text, encoding="utf-8")

    def checkpoint(self, job_id: str, token: int) -> Path:
        """Where the holder of this token keeps the job's Film: no two holders share a file."""
        return self.job_file(job_id, f"film-{token}.npz")

    def newest_checkpoint(self, job_id: str) -> Path | None:
        """The Film of the latest holder that wrote one."""
        return max(self._checkpoints(job_id), key=_token_of, default=None)

    def drop_checkpoints(self, job_id: str, before: int) -> None:
        """Remove the Films of holders before this token."""
        for path in self._checkpoints(job_id):
            if _token_of(path) < before:
                path.unlink(missing_ok=True)

    def hand_on(self, old: str, new: str) -> bool:
        """Let a job that has not begun find the Film of another one, and its pictures; False if that has none."""
        film = self.newest_checkpoint(old)
        if film is None:
            return False
        self.open_job(new)
        # None is ever written to, only replaced.
        self.checkpoint(new, 0).hardlink_to(film)
        self.job_file(new, "preview.png").hardlink_to(self.job_file(old, "preview.png"))
        with suppress(FileNotFoundError):  # It ended under a version that wrote none.
            self.job_file(new, "thumbnail.webp").hardlink_to(self.job_file(old, "thumbnail.webp"))
        return True

    def _checkpoints(self, job_id: str) -> list[Path]:
        with suppress(FileNotFoundError):
            return [path for path in (self.jobs / job_id).iterdir() if _CHECKPOINT.fullmatch(path.name)]
        return []


def _token_of(path: Path) -> int:
    match = _CHECKPOINT.fullmatch(path.name)
    return int(match[1]) if match else -1


def _sync_folder(folder: Path) -> None:
    """A rename is durable once its folder is."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
