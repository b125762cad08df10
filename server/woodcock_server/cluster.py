"""The Dask cluster that renders: a supervised worker process for each device, embedded or on other machines."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, asynccontextmanager
from pathlib import Path
from typing import Any, TypeAlias

import dask
import structlog
from distributed import Client, Nanny, Scheduler, SpecCluster
from distributed.client import FutureCancelledError

from woodcock_server import certificate, worker
from woodcock_server.devices.service import Found
from woodcock_server.steady import keep_time

log = structlog.get_logger()

#: How often a range's worker may die before the job is given up.
DEATHS_ALLOWED = 3

SUPERVISION_SECONDS = 5.0
RESTART_SECONDS = 30.0

#: How long a worker may take to come back. Dask's own 15 s are too few where other devices' workers take all cores: it
#: would end the one that was about to be ready, and begin anew.
START_SECONDS = 60

#: Each part also opens an HTTP server, wanted or not: on the loopback, on any port, with nothing to serve.
HTTP: dict[str, Any] = {"dashboard": False, "dashboard_address": "127.0.0.1:0"}

#: Of Dask, for every part of a cluster.
SETTINGS = {
    "distributed.scheduler.allowed-failures": DEATHS_ALLOWED,
    # What takes the memory is a scene, of which nothing can be put aside: up to the limit all is well.
    **{f"distributed.worker.memory.{step}": False for step in ("target", "spill", "pause")},
    "distributed.worker.memory.terminate": 1.0,
    "distributed.deploy.lost-worker-timeout": START_SECONDS,
    # Workers would look at their own stacks a hundred times a second and at their clocks fifty times.
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}

#: Where workers find uploaded files, by their ids, for as long as a block takes. Raises OSError, StoreAway.
Files: TypeAlias = Callable[[Iterable[str]], AbstractContextManager[Mapping[str, Path | str]]]


class GivenUpError(RuntimeError):
    """The cluster forgot what it was asked for."""


class DeviceGoneError(RuntimeError):
    """A device left the cluster; whatever it was sent to do comes to nothing. Never raised by an embedded cluster."""


class Cluster:
    """The devices of a service and their worker processes, which may come and go.

    devices: those that there are now; remote: more may come.
    """

    remote = False

    def __init__(self, client: Client, devices: Sequence[Found], files: Files) -> None:
        self._client, self.devices, self.files = client, devices, files

    @property
    def ready(self) -> dict[str, Found]:
        """Devices that can be used, by id."""
        return {device.id: device for device in self.devices if device.ready}

    @property
    def fault(self) -> str | None:
        """Why there is no device to render on; None if there is one."""
        return None if self.ready else "No OpenCL device is ready; /api/v1/devices says why."

    async def changed(self) -> None:
        """Returns when devices have come or gone since the call."""
        await asyncio.Event().wait()

    async def ask(self, device_id: str, key: str, function: Callable[..., Any], *args: Any) -> Any:
        """Run a function on a device's worker; key: a new one. Raises KilledWorker, DeviceGoneError, and what the
        function raises."""
        return await ask(self._client, device_id, key, function, *args)

    async def restart(self, device_id: str) -> None:
        """Kill the process of a device's worker, whatever it is doing; a new one takes its place."""
        await restart(self._client, device_id)


def resource(device_id: str) -> dict[str, int]:
    """What binds a task to a device. A worker's name or address would not do: a restarted worker has new ones."""
    return {f"device:{device_id}": 1}


async def ask(client: Client, device_id: str, key: str, function: Callable[..., Any], *args: Any) -> Any:
    """Run a function on a device's worker; key: a new one. Raises KilledWorker, and what the function raises."""
    future = client.submit(function, *args, key=key, resources=resource(device_id), pure=False)
    # All who wait share one gathering of the client's: one who was cancelled in it would cancel it for all, and the
    # client would go on handing it out.
    outcome = asyncio.ensure_future(future)
    outcome.add_done_callback(lambda done: done.cancelled() or done.exception())
    try:
        return await asyncio.shield(outcome)
    except FutureCancelledError as error:
        raise GivenUpError(f"the cluster gave up {function.__name__} on {device_id}: {error.reason}") from None
    finally:
        future.release()  # type: ignore[no-untyped-call]


async def restart(client: Client, device_id: str) -> None:
    """Kill the process of a device's worker, whatever it is doing; a new one takes its place."""
    assert client.scheduler is not None, "the client is connected"
    scheduler = await client.scheduler.identity(n_workers=-1)
    bound = resource(device_id)
    workers = [address for address, one in scheduler["workers"].items() if one["resources"].keys() == bound.keys()]
    log.warning("worker killed", device=device_id)
    await client.restart_workers(workers, timeout=RESTART_SECONDS, raise_for_error=False)


def worker_options(scratch: Path, memory: int) -> dict[str, Any]:
    """Of a nanny. memory: bytes; a worker that takes more is killed."""
    return {
        "nthreads": 1,
        "preload": [worker.__name__],
        "memory_limit": memory,
        "local_directory": str(scratch),
        "silence_logs": logging.WARNING,
    }


@asynccontextmanager
async def embedded(device_ids: Sequence[str], scratch: Path, memory: int) -> AsyncIterator[Client]:
    """A client of a cluster inside this process, its workers in processes of their own; a nanny restarts a dead one.

    memory: bytes; a worker that takes more is killed.
    """
    keep_time()
    # Whoever can speak to a scheduler or a worker runs code in it. Only who has this start's certificate can, which
    # is made here and is nowhere but in these processes' memory.
    secure = certificate.security()
    local: dict[str, Any] = {"host": "127.0.0.1", "protocol": "tls://", "security": secure, **HTTP}
    options = {**local, **worker_options(scratch, memory)}
    workers = {
        device_id: {"cls": Nanny, "options": {**options, "resources": resource(device_id)}} for device_id in device_ids
    }
    with dask.config.set(SETTINGS):
        async with (
            SpecCluster(  # type: ignore[no-untyped-call]
                scheduler={"cls": Scheduler, "options": local},
                workers=workers,
                asynchronous=True,
                security=secure,
                silence_logs=logging.WARNING,
            ) as cluster,
            Client(  # type: ignore[no-untyped-call]
                cluster, asynchronous=True, direct_to_workers=True, security=secure, set_as_default=False
            ) as client,
        ):
            supervision = asyncio.create_task(_supervise(cluster))
            try:
                yield client
            finally:
                supervision.cancel()


async def _supervise(cluster: SpecCluster) -> None:
    """Start again what is gone for good: a nanny gives up when its worker dies before it is up.

    Dask forgets the two some seconds later, and to await a cluster starts what it lacks.
    """
    while True:
        await asyncio.sleep(SUPERVISION_SECONDS)
        try:
            await cluster
        except Exception as error:
            log.error("workers not started", reason=repr(error))
