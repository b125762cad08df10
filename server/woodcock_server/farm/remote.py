"""The service's side of a farm: a cluster on other machines, whose devices come and go."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import asynccontextmanager, nullcontext, suppress
from dataclasses import asdict
from typing import Any

import dask
import structlog
from distributed import Client, Security, rpc

from woodcock import __version__
from woodcock.device import Device
from woodcock.probe import Probe
from woodcock_server.cluster import SETTINGS, Cluster, DeviceGoneError, Files, GivenUpError, ask, restart
from woodcock_server.devices.service import Found
from woodcock_server.farm import files
from woodcock_server.steady import keep_time
from woodcock_server.storage import Storage

log = structlog.get_logger()

#: How often the scheduler is asked who is there, seconds.
LOOK_EVERY = 1.0

#: How long a worker may be away before its device counts as gone, seconds: one that died is started again within them.
AWAY_SECONDS = 20.0

#: How long a scheduler that is asked once may take to answer, seconds.
ANSWER_SECONDS = 10.0

#: Of the startup information of a worker, what it says of its host's devices.
DEVICES = "woodcock"


def told(found: Found) -> dict[str, Any]:
    """A device as its worker tells the scheduler of it."""
    return {**asdict(found), "version": __version__}


def _understood(said: Mapping[str, Any]) -> Found:
    device, version = Device(**said["device"]), said["version"]
    probe = Probe(tuple(said["probe"]["lanes"]), said["probe"]["fault"])
    if version != __version__:  # Its samples might be others.
        probe = Probe((), f"{said['host']} runs Woodcock {version}, this server {__version__}.")
    return Found(device, probe, said["fingerprint"], said["host"])


async def look(address: str, secure: Security) -> dict[str, Found]:
    """Devices, by id, that a scheduler's workers have now. Raises OSError where it cannot be reached."""
    arguments = secure.get_connection_args("client")  # type: ignore[no-untyped-call]
    reached = rpc(address, timeout=ANSWER_SECONDS, connection_args=arguments)  # type: ignore[no-untyped-call]
    async with reached as scheduler:
        identity = await scheduler.identity(n_workers=-1)
    return {found.id: found for worker in identity["workers"].values() for found in _devices(worker)}


def _devices(worker: Mapping[str, Any]) -> Iterator[Found]:
    """Of a worker's host, as the scheduler knows it."""
    return map(_understood, worker.get(DEVICES, ()))


class Remote(Cluster):
    """A cluster that is reached by its scheduler's address, as long as that answers."""

    remote = True

    def __init__(self, address: str, secure: Security, files: Files) -> None:
        self.files = files
        self._address, self._secure = address, secure
        self._connected: Client | None = None
        self.devices: list[Found] = []
        self._last: dict[str, float] = {}  # device id -> when its worker was there last
        self._gone: dict[str, asyncio.Event] = {}
        self._changed = asyncio.Event()

    @property
    def fault(self) -> str | None:
        if self._connected is None:
            return f"The scheduler at {self._address} does not answer."
        return None if self.ready else f"No worker with a device is connected to the scheduler at {self._address}."

    async def changed(self) -> None:
        await self._changed.wait()

    async def ask(self, device_id: str, key: str, function: Callable[..., Any], *args: Any) -> Any:
        if self._connected is None or device_id not in self._gone:
            raise DeviceGoneError(f"{device_id} is not connected")
        gone = asyncio.create_task(self._gone[device_id].wait())
        asked = asyncio.create_task(ask(self._connected, device_id, key, function, *args))
        try:
            await asyncio.wait({asked, gone}, return_when=asyncio.FIRST_COMPLETED)
            if asked.done():
                return asked.result()
        except (GivenUpError, OSError) as error:  # What functions raise themselves is none of these.
            raise DeviceGoneError(f"{device_id} did not answer: {error}") from None
        finally:
            for task in (asked, gone):
                task.cancel()
            await asyncio.gather(asked, gone, return_exceptions=True)
        raise DeviceGoneError(f"{device_id} is gone")

    async def restart(self, device_id: str) -> None:
        if self._connected is not None:
            await restart(self._connected, device_id)

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Keep the connection, and learn of devices."""
        keeping = asyncio.create_task(self._keep(), name="connection to the scheduler")
        try:
            yield
        finally:
            keeping.cancel()
            with suppress(asyncio.CancelledError):
                await keeping

    async def _keep(self) -> None:
        said = ""
        while True:
            try:
                async with Client(  # type: ignore[no-untyped-call]
                    self._address, asynchronous=True, direct_to_workers=True, security=self._secure,
                    set_as_default=False,
                ) as client:  # fmt: skip
                    log.info("scheduler found", address=self._address)
                    said = ""
                    await self._look(client)
            except Exception as error:  # Of whatever kind: it is tried again.
                if (reason := str(error) or repr(error)) != said:
                    log.warning("scheduler does not answer", address=self._address, reason=reason)
                    said = reason
            await asyncio.sleep(LOOK_EVERY)

    async def _look(self, client: Client) -> None:
        """Until the connection breaks."""
        try:
            while client.status == "running" and client.scheduler is not None:
                identity = await client.scheduler.identity(n_workers=-1)
                self._connected = client
                self._note(identity["workers"].values(), time.monotonic())
                await asyncio.sleep(LOOK_EVERY)
        finally:
            self._connected = None
            self._note([], float("inf"))

    def _note(self, workers: Any, now: float) -> None:
        """Who is there now, and who has been away for too long."""
        known = {found.id: found for found in self.devices}
        for worker in workers:
            for found in _devices(worker):
                known[found.id] = found
                self._last[found.id] = now
        for device_id in [each for each in known if now - self._last[each] > AWAY_SECONDS]:
            del known[device_id], self._last[device_id]
            self._gone.pop(device_id).set()
            log.warning("device gone", device=device_id)
        for device_id in known.keys() - self._gone.keys():
            self._gone[device_id] = asyncio.Event()
            log.info("device came", device=device_id)
        # A new list: other threads may look through the one before.
        devices = [known[device_id] for device_id in sorted(known)]
        if devices != self.devices:
            self.devices = devices
            self._changed.set()
            self._changed = asyncio.Event()


@asynccontextmanager
async def joined(address: str, secure: Security, port: int, storage: Storage) -> AsyncIterator[Cluster]:
    """The cluster at a scheduler's address, whether that answers now or later; port: of `files.serving`."""
    keep_time()
    for name in ("distributed", "distributed.client", "distributed.core"):  # Who does not answer is told of here.
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with dask.config.set(SETTINGS):
        async with files.serving(address, port, secure, storage) as own:
            cluster = Remote(address, secure, lambda ids: nullcontext({each: f"{own}/{each}" for each in ids}))
            async with cluster.running():
                yield cluster
