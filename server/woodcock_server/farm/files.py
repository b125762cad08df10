"""Uploaded files on their way to worker hosts: a service says where they lie, and serves them where nobody else does,
over the TLS of the farm."""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from typing import Any

import structlog
from distributed import Security
from distributed.comm.core import connect
from distributed.core import Server, send_recv

from woodcock.scene import UPLOADED
from woodcock_server.farm import objects
from woodcock_server.farm.address import own_host
from woodcock_server.storage import Storage, StoreAway

log = structlog.get_logger()

#: Bytes that are read and sent at a time.
CHUNK = 4 << 20
#: How long a service, or a store that has answered, may not answer, seconds.
PATIENCE = 60.0
#: Between two questions to who does not answer, seconds.
AGAIN_SECONDS = 1.0

_ID = re.compile(rf"{UPLOADED}[0-9a-f]{{64}}")


@asynccontextmanager
async def serving(scheduler: str, port: int, secure: Security, storage: Storage) -> AsyncIterator[str]:
    """Let workers read files, at the address that this machine has towards the scheduler, which is yielded.

    port: 0 for any.
    """

    async def source(file: str) -> tuple[int, str | None]:
        return await asyncio.to_thread(storage.volume_source, known(file))

    async def read(file: str, offset: int) -> bytes:
        return await asyncio.to_thread(storage.read_volume, known(file), offset, CHUNK)

    def known(file: str) -> str:
        if not _ID.fullmatch(file):
            raise FileNotFoundError(file)
        return file

    server = Server({"source": source, "read": read})  # type: ignore[no-untyped-call]
    own = f"tls://{own_host(scheduler)}:{port}"
    await server.listen(own, **secure.get_listen_args("scheduler"))  # type: ignore[no-untyped-call]
    try:
        yield server.address
    finally:
        await server.close()


class Peer:
    """A service as a source of files, for threads that have no event loop; cache.Source. What lies in an object store
    is read there; through the service, if it cannot be. A connection that breaks is made again.

    Methods raise TimeoutError for a service that does not answer, StoreAway for one whose store does not, OSError for a
    file that it has not."""

    def __init__(self, address: str, secure: Security) -> None:
        self._address, self._secure = address, secure

    def size(self, file_id: str) -> int:
        return self._source(file_id)[0]

    def chunks(self, file_id: str) -> Iterator[bytes]:
        size, url = self._source(file_id)
        offset, until = 0, time.monotonic() + PATIENCE
        while url is not None and offset < size:
            try:
                for chunk in objects.read(url, offset, size):
                    offset, until = offset + len(chunk), time.monotonic() + PATIENCE
                    yield chunk
            except objects.Unread as error:
                if time.monotonic() > until or not (error.again or offset):
                    log.warning(
                        "object store out of reach; reading through the service", file=file_id, reason=str(error)
                    )
                    break
                time.sleep(AGAIN_SECONDS)
                size, url = self._source(file_id)  # The one before may not be good any more.
        while offset < size:
            chunk = self._ask(op="read", file=file_id, offset=offset)
            if not chunk:
                raise OSError(f"{file_id} is shorter than it was")
            offset += len(chunk)
            yield chunk

    def _source(self, file_id: str) -> tuple[int, str | None]:
        size, url = self._ask(op="source", file=file_id)
        return size, url

    def _ask(self, **message: Any) -> Any:
        end = time.monotonic() + PATIENCE
        while True:
            try:
                return asyncio.run(self._send(message))
            except FileNotFoundError:
                raise
            except StoreAway:
                if time.monotonic() > end:
                    raise
            except OSError as error:
                if time.monotonic() > end:
                    raise TimeoutError(f"the service at {self._address} does not answer: {error}") from None
            time.sleep(AGAIN_SECONDS)

    async def _send(self, message: dict[str, Any]) -> Any:
        comm = await connect(self._address, **self._secure.get_connection_args("worker"))  # type: ignore[no-untyped-call]
        try:
            return await asyncio.wait_for(send_recv(comm, close=True, **message), PATIENCE)
        finally:
            comm.abort()
