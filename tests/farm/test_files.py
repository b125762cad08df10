"""Uploaded files on their way to a worker host: from the object store that the service names, else through it."""

from __future__ import annotations

import asyncio
import hashlib
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
from structlog.testing import capture_logs

from woodcock_server import certificate
from woodcock_server.farm import files
from woodcock_server.farm.cache import Cache
from woodcock_server.storage import Storage, StoreAway

CONTENT = np.random.default_rng(1).bytes(9 << 20)
FILE = f"sha256:{hashlib.sha256(CONTENT).hexdigest()}"
SECRET = "X-Amz-Signature=0123"


class Objects(ThreadingHTTPServer):
    """A store of one object. breaks: after so many bytes of an answer each connection breaks, in turn; statuses: said
    of answers, in turn; ranges: what was asked for; broken: called before a connection breaks."""

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Answer)
        self.breaks: list[int] = []
        self.statuses: list[int] = []
        self.ranges: list[str] = []
        self.broken: Callable[[], object] = int

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}/volumes/x?{SECRET}"


class Answer(BaseHTTPRequestHandler):
    server: Objects

    def do_GET(self) -> None:
        asked = self.headers["Range"]
        self.server.ranges.append(asked)
        start, stop = (int(each) for each in asked.removeprefix("bytes=").split("-"))
        body = CONTENT[start : stop + 1]
        self.send_response(self.server.statuses.pop(0) if self.server.statuses else 206)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if self.server.breaks:
            self.server.broken()
            body = body[: self.server.breaks.pop(0)]
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        pass


class Signing(Storage):
    """A folder as if it were a bucket. away: how often the store does not answer; through: parts read here."""

    url: str | None = None
    away = 0
    through = 0

    def volume_source(self, volume_id: str) -> tuple[int, str | None]:
        if self.away:
            self.away -= 1
            raise StoreAway
        return len(CONTENT), self.url

    def read_volume(self, volume_id: str, offset: int, length: int) -> bytes:
        self.through += 1
        return super().read_volume(volume_id, offset, length)


@pytest.fixture
def objects() -> Iterator[Objects]:
    with Objects() as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        yield server
        server.shutdown()
        thread.join()


@pytest.fixture
def storage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Signing:
    monkeypatch.setattr(files, "AGAIN_SECONDS", 0.01)
    storage = Signing(tmp_path / "data")
    storage.volume_file(FILE).write_bytes(CONTENT)
    return storage


@contextmanager
def peer(storage: Storage) -> Iterator[files.Peer]:
    """Of a service that has this storage, on an event loop of its own."""
    secure, loop = certificate.security(), asyncio.new_event_loop()
    address, over = asyncio.Queue[str](), asyncio.Event()

    async def serve() -> None:
        async with files.serving("tls://127.0.0.1:8786", 0, secure, storage) as own:
            await address.put(own)
            await over.wait()

    thread = threading.Thread(target=loop.run_until_complete, args=(serve(),))
    thread.start()
    try:
        yield files.Peer(asyncio.run_coroutine_threadsafe(address.get(), loop).result(10), secure)
    finally:
        loop.call_soon_threadsafe(over.set)
        thread.join()
        loop.close()


def fetched(storage: Storage, folder: Path) -> bytes:
    with peer(storage) as service:
        return Cache(folder, 1 << 30).fetch(FILE, service).path.read_bytes()


def test_a_file_comes_from_the_store_that_the_service_names(storage: Signing, objects: Objects, tmp_path: Path) -> None:
    storage.url = objects.url
    assert fetched(storage, tmp_path / "cache") == CONTENT
    assert (storage.through, objects.ranges) == (0, [f"bytes=0-{len(CONTENT) - 1}"])


def test_a_connection_that_breaks_is_gone_on_with(storage: Signing, objects: Objects, tmp_path: Path) -> None:
    """And what has come is not asked for again, also if the store did not answer the service in between."""
    storage.url, objects.breaks = objects.url, [3 << 20, (2 << 20) + 7]
    objects.broken = partial(setattr, storage, "away", 2)
    assert fetched(storage, tmp_path / "cache") == CONTENT
    begins = [0, 3 << 20, (5 << 20) + 7]
    assert (storage.through, objects.ranges) == (0, [f"bytes={begin}-{len(CONTENT) - 1}" for begin in begins])


def test_a_store_that_is_busy_is_asked_again(storage: Signing, objects: Objects, tmp_path: Path) -> None:
    storage.url, objects.statuses = objects.url, [503, 500]
    assert fetched(storage, tmp_path / "cache") == CONTENT
    assert (storage.through, len(objects.ranges)) == (0, 3)


@pytest.mark.parametrize("status", [None, 200, 403])
def test_what_the_store_does_not_give_comes_through_the_service(
    storage: Signing, objects: Objects, tmp_path: Path, status: int | None
) -> None:
    """It says so once, and nothing of the URL."""
    storage.url = objects.url
    if status is None:
        objects.server_close()
        objects.shutdown()
    else:
        objects.statuses = [status]
    with capture_logs() as said:
        assert fetched(storage, tmp_path / "cache") == CONTENT
    assert storage.through == 3
    reason = "[Errno 111] Connection refused" if status is None else f"it answered {status}"
    (line,) = said
    assert line == {
        "event": "object store out of reach; reading through the service",
        "log_level": "warning",
        "file": FILE,
        "reason": reason,
    }


def test_who_is_out_of_patience_says_that_the_store_is_away(
    storage: Signing, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "PATIENCE", 0.2)
    storage.away = 1000
    with pytest.raises(StoreAway, match="The object store does not answer; "):
        fetched(storage, tmp_path / "cache")
    assert [path.name for path in (tmp_path / "cache").iterdir()] == ["lock"], "nothing half-written stays"
