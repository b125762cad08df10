"""Uploaded files on their way from a service to worker hosts, over the TLS of the farm."""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from distributed import Security
from distributed.comm.addressing import get_address_host
from distributed.comm.core import connect
from distributed.core import Server, send_recv
from distributed.utils import get_ip

from woodcock.scene import UPLOADED

#: Bytes that are read and sent at a time.
CHUNK = 4 << 20
#: How long a service may not answer, seconds.
PATIENCE = 60.0

_ID = re.compile(rf"{UPLOADED}[0-9a-f]{{64}}")


@asynccontextmanager
async def serving(scheduler: str, port: int, secure: Security, find: Callable[[str], Path]) -> AsyncIterator[str]:
    """Let workers read files, at the address that this machine has towards the scheduler, which is yielded.

    port: 0 for any; find: where a file lies, by its id.
    """

    async def size(file: str) -> int:
        return (await asyncio.to_thread(found(file).stat)).st_size

    async def read(file: str, offset: int) -> bytes:
        return await asyncio.to_thread(_read, found(file), offset)

    def found(file: str) -> Path:
        if not _ID.fullmatch(file):
            raise FileNotFoundError(file)
        return find(file)

    server = Server({"size": size, "read": read})  # type: ignore[no-untyped-call]
    host = get_ip(get_address_host(scheduler))  # type: ignore[no-untyped-call]
    own = f"tls://[{host}]:{port}" if ":" in host else f"tls://{host}:{port}"
    await server.listen(own, **secure.get_listen_args("scheduler"))  # type: ignore[no-untyped-call]
    try:
        yield server.address
    finally:
        await server.close()


def _read(path: Path, offset: int) -> bytes:
    with path.open("rb") as file:
        file.seek(offset)
        return file.read(CHUNK)


class Peer:
    """A service as a source of files, for threads that have no event loop; cache.Source. A connection that breaks is
    made again. Methods raise TimeoutError for a service that does not answer, OSError for a file that it has not."""

    def __init__(self, address: str, secure: Security) -> None:
        self._address, self._secure = address, secure

    def size(self, file_id: str) -> int:
        size: int = self._ask(op="size", file=file_id)
        return size

    def chunks(self, file_id: str) -> Iterator[bytes]:
        size, offset = self.size(file_id), 0
        while offset < size:
            chunk: bytes = self._ask(op="read", file=file_id, offset=offset)
            if not chunk:
                raise OSError(f"{file_id} is shorter than it was")
            offset += len(chunk)
            yield chunk

    def _ask(self, **message: Any) -> Any:
        end = time.monotonic() + PATIENCE
        while True:
            try:
                return asyncio.run(self._send(message))
            except FileNotFoundError:
                raise
            except OSError as error:
                if time.monotonic() > end:
                    raise TimeoutError(f"the service at {self._address} does not answer: {error}") from None
                time.sleep(1)

    async def _send(self, message: dict[str, Any]) -> Any:
        comm = await connect(self._address, **self._secure.get_connection_args("worker"))  # type: ignore[no-untyped-call]
        try:
            return await asyncio.wait_for(send_recv(comm, close=True, **message), PATIENCE)
        finally:
            comm.abort()
