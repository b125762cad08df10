"""What is done before anybody asks for it: drivers are loaded, and the generic program is built."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

import structlog

from woodcock.device import Device
from woodcock.start import Build
from woodcock_server import worker
from woodcock_server.cluster import Cluster
from woodcock_server.identifiers import new_id

log = structlog.get_logger()

#: How often a build is looked at, seconds.
LOOK_EVERY = 0.5


@asynccontextmanager
async def running(cluster: Cluster, devices: Sequence[Device]) -> AsyncIterator[None]:
    """Prepare devices in the background, those of the same make one after the other; at the end what is under way is
    given up.
    """
    tasks = [asyncio.create_task(_load(cluster, device)) for device in devices]
    tasks.append(asyncio.create_task(build(devices)))
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def _load(cluster: Cluster, device: Device) -> None:
    try:
        await cluster.ask(device.id, f"load-{new_id()}", worker.load, device.id)
    except Exception as error:  # A job will find out, and say so to the one who asked for it.
        log.warning("driver not loaded", device=device.id, reason=str(error))


async def build(devices: Sequence[Device]) -> None:
    """One at a time, on one core: the second of a make finds the first one's program."""
    for device in devices:
        build = Build(device, None)
        try:
            while build.running:
                await asyncio.sleep(LOOK_EVERY)
            if fault := build.fault():
                log.warning("no generic program", device=device.id, reason=fault)
            else:
                log.info("generic program ready", device=device.id)
        finally:
            build.end()
