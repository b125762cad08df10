"""An S3 bucket, as the few things that are asked of it."""

from __future__ import annotations

import hashlib
import os
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import datetime, timedelta
from pathlib import Path
from typing import NamedTuple

import obstore
import structlog
from obstore.exceptions import BaseError
from obstore.store import ObjectStore, S3Store

from woodcock_server.storage import PROBE, NoStore, StoreAway

log = structlog.get_logger()

#: Between two looks whether the store is back, seconds.
LOOK_EVERY = 1.0
#: Objects above it are sent in parts, of this size each, bytes; so many at a time.
PART, PARTS = 8 << 20, 4
#: More than that S3 copies in parts only, bytes.
LARGEST_COPY = 5 << 30
#: How long a URL is good for: it is used at once, but by the store's clock, which may be another by as much.
URL_VALID = timedelta(minutes=15)


class Found(NamedTuple):
    """size: bytes; modified: when it was written."""

    key: str
    size: int
    modified: datetime


def connect(url: str) -> Store:
    """The bucket, and the prefix in it, of a URL; credentials, region and endpoint are the environment's (AWS_…).

    Nothing is asked of it yet. Raises NoStore."""
    try:
        return Store(_s3(url))
    except (BaseError, ValueError) as error:
        raise NoStore(url, str(error)) from None


def _s3(url: str) -> ObjectStore:
    endpoint = os.environ.get("AWS_ENDPOINT_URL_S3") or os.environ.get("AWS_ENDPOINT_URL", "")
    return S3Store.from_url(
        url,
        # Checked by the store as it comes in.
        config={"checksum_algorithm": "SHA256", **({"endpoint": endpoint} if endpoint else {})},
        # A large object may take hours as long as bytes come; a store that says nothing is away.
        client_options={
            "connect_timeout": "3s",
            "read_timeout": "10s",
            "timeout": "24h",
            "allow_http": endpoint.startswith("http://"),
        },
        # What is asked of it is asked again by whoever needs it: here only for what passes in a moment.
        retry_config={
            "max_retries": 3,
            "retry_timeout": timedelta(seconds=5),
            "backoff": {"init_backoff": timedelta(seconds=0.1), "max_backoff": timedelta(seconds=1), "base": 2},
        },
    )


class Store:
    """Objects by their keys. Methods block, and raise StoreAway where the store does not answer, or refuses: the first
    one after a while, the others at once until it answers again, so that whoever can wait is not held up."""

    def __init__(self, store: ObjectStore) -> None:
        self._store = store
        self._away = False
        self._lock = threading.Lock()

    def try_writing(self) -> None:
        self.put(PROBE, b"")

    def put(self, key: str, content: Path | bytes) -> None:
        """The whole appears under its key, or nothing."""
        with self._answering(missing=False):
            obstore.put(self._store, key, content, chunk_size=PART, max_concurrency=PARTS)

    def fetch(self, key: str, path: Path) -> str:
        """Write an object to a file; returns its SHA-256, 64 hex digits. Raises FileNotFoundError, OSError."""
        digest = hashlib.sha256()
        with self._answering():
            parts = iter(obstore.get(self._store, key).stream(PART))
        with path.open("wb") as file:
            while True:
                with self._answering():
                    part = next(parts, None)
                if part is None:
                    return digest.hexdigest()
                file.write(part)
                digest.update(part)

    def read(self, key: str, offset: int, length: int) -> bytes:
        """Part of an object, less at its end. Raises FileNotFoundError."""
        with self._answering():
            return bytes(obstore.get_range(self._store, key, start=offset, length=length))

    def url(self, key: str) -> str:
        """By which whoever has it can read an object, and nothing else, for as long as URL_VALID."""
        assert isinstance(self._store, S3Store), "others sign nothing"
        with self._answering(missing=False):
            return obstore.sign(self._store, "GET", key, URL_VALID)

    def size(self, key: str) -> int | None:
        """Of an object, bytes; None where there is none."""
        try:
            with self._answering():
                return obstore.head(self._store, key)["size"]
        except FileNotFoundError:
            return None

    def copy(self, old: str, new: str) -> None:
        """Within the store; LARGEST_COPY at most. Raises FileNotFoundError."""
        with self._answering():
            obstore.copy(self._store, old, new)

    def delete(self, keys: Sequence[str]) -> None:
        """Those that there are."""
        with self._answering(missing=False):
            if keys:
                obstore.delete(self._store, keys)

    def list(self, prefix: str) -> Iterator[list[Found]]:
        """What there is, some at a time."""
        with self._answering(missing=False):
            pages = iter(obstore.list(self._store, prefix, chunk_size=500))
        while True:
            with self._answering(missing=False):
                page = next(pages, None)
            if page is None:
                return
            yield [Found(each["path"], each["size"], each["last_modified"]) for each in page]

    @contextmanager
    def _answering(self, missing: bool = True) -> Iterator[None]:
        """missing: whether FileNotFoundError is an answer; that the bucket is missing is none."""
        if self._away:
            raise StoreAway
        try:
            yield
        except (BaseError, OSError) as error:
            if missing and isinstance(error, FileNotFoundError) and "NoSuchBucket" not in str(error):
                raise
            self._leave(error)
            raise StoreAway from None

    def _leave(self, error: Exception) -> None:
        with self._lock:
            if self._away:
                return
            self._away = True
        log.error("the object store does not answer", reason=" ".join(str(error).split("Debug source")[0].split()))
        threading.Thread(target=self._watch, name="store", daemon=True).start()

    def _watch(self) -> None:
        while True:
            time.sleep(LOOK_EVERY)
            try:
                obstore.put(self._store, PROBE, b"")
            except (BaseError, OSError):
                continue
            self._away = False
            log.info("the object store answers again")
            return
