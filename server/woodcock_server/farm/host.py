"""A worker host of a farm: a supervised worker process for each of its devices, for as long as the command runs."""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import Sequence
from typing import Any

import dask
import structlog
from distributed import Nanny, Security
from distributed.core import Status

from woodcock_server import preparation
from woodcock_server.cluster import HTTP, SETTINGS, START_SECONDS, resource, worker_options
from woodcock_server.devices.service import Found
from woodcock_server.farm.address import own_host
from woodcock_server.farm.remote import told
from woodcock_server.farm.signs import ALIVE, CONNECTED, given
from woodcock_server.steady import keep_time
from woodcock_server.worker import FOUND

log = structlog.get_logger()

#: Between a connection that broke, or could not be made, and the next one, seconds.
AGAIN_SECONDS = 1.0


async def work(address: str, secure: Security, found: Sequence[Found], memory: int, *, prepare: bool) -> None:
    """Offer devices to the scheduler at an address until cancelled, whether it answers or not.

    found: of this host, one of them ready at least; memory: bytes; a worker that takes more is killed; prepare: build
    the generic program.
    """
    keep_time()
    # Who does not answer is told of here.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    for name in ("core", "nanny", "comm"):
        logging.getLogger(f"distributed.{name}").setLevel(logging.CRITICAL)
    failed = [told(one) for one in found if not one.ready]
    ready = [one for one in found if one.ready]
    connected: set[str] = set()

    def signs() -> list[str]:
        return [ALIVE, CONNECTED] if len(connected) == len(ready) else [ALIVE]

    with dask.config.set(SETTINGS):
        async with given(signs) as scratch, asyncio.TaskGroup() as group:
            options = {"protocol": "tls://", "security": secure, **HTTP, **worker_options(scratch, memory)}
            for one in ready:
                said = json.dumps([told(one), *failed])
                own = {**options, "resources": resource(one.id), "env": {FOUND: said}}
                group.create_task(_offer(address, one.id, own, connected))
            if prepare:
                group.create_task(preparation.build([one.device for one in ready]))


async def _offer(address: str, device_id: str, options: dict[str, Any], connected: set[str]) -> None:
    """A worker, and a new one whenever it has lost the scheduler or could not be started; connected: the devices whose
    workers are with the scheduler, this one among them for as long as it is."""
    while True:
        try:
            async with Nanny(address, host=own_host(address), **options) as nanny:
                log.info("device offered", device=device_id, scheduler=address)
                await _over(nanny, device_id, connected)
                log.warning("scheduler lost; trying again", device=device_id)
        except Exception as error:
            log.warning("device not offered; trying again", device=device_id, reason=repr(error.__cause__ or error))
        await asyncio.sleep(AGAIN_SECONDS)


async def _over(nanny: Nanny, device_id: str, connected: set[str]) -> None:
    """Returns when a nanny has ended, or has had no worker for so long that it has given up on it."""
    without = 0.0
    try:
        while nanny.status not in (Status.closing, Status.closed, Status.failed) and without < START_SECONDS:
            # It runs only once it has found the scheduler.
            if nanny.process is not None and nanny.process.status is Status.running:
                connected.add(device_id)
                without = 0.0
            else:
                connected.discard(device_id)
                without += AGAIN_SECONDS
            await asyncio.sleep(AGAIN_SECONDS)
    finally:
        connected.discard(device_id)
