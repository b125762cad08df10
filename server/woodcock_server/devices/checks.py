"""Stability checks: one at a time on a device, never while that renders, their outcomes kept.

A check that is under way is known to its server alone and ends with it; the database holds outcomes only, so none is
ever left there unfinished.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Collection
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime
from typing import Any

import structlog
from distributed.scheduler import KilledWorker
from sqlalchemy import Connection, Engine
from sqlalchemy.exc import SQLAlchemyError

from woodcock_server import worker
from woodcock_server.cluster import Cluster, DeviceGoneError
from woodcock_server.devices import repository
from woodcock_server.devices.schemas import StabilityRow
from woodcock_server.devices.service import Found
from woodcock_server.identifiers import new_id
from woodcock_server.threads import in_thread

log = structlog.get_logger()

RETRY_SECONDS = 1.0  # after the database did not take an outcome

#: A device that so many jobs in a row were lost on is quarantined.
LOST_IN_A_ROW = 2


class Checks:
    """The checks of a server's devices. For the event loop's thread, except where a connection is passed."""

    def __init__(self, engine: Engine, cluster: Cluster) -> None:
        self._engine, self._cluster = engine, cluster
        #: Device id -> when its check began; None while that waits for a job to leave the device.
        self.under_way: dict[str, datetime | None] = {}
        self._occupied: set[str] = set()
        self._changed = asyncio.Event()  # another set of devices is occupied
        self._tasks: set[asyncio.Task[None]] = set()
        self._lost: dict[str, list[tuple[str, str]]] = {}  # device id -> jobs in a row that it failed, and how

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Checks may be asked for; at the end those that are under way are given up."""
        try:
            yield
        finally:
            for task in self._tasks:
                task.cancel()
            await asyncio.gather(*self._tasks, return_exceptions=True)

    def ask(self, device_id: str) -> None:
        """Check a device that is ready as soon as no job renders on it, unless that is under way."""
        if device_id not in self.under_way:
            self.under_way[device_id] = None
            task = asyncio.create_task(self._check(self._cluster.ready[device_id]), name=f"check of {device_id}")
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    # For the dispatcher

    @property
    def free(self) -> list[str]:
        """The ready devices that no check has or waits for."""
        return [device_id for device_id in self._cluster.ready if device_id not in self.under_way]

    def occupy(self, device_ids: Collection[str]) -> None:
        """Jobs have these devices, all of them free, and leave all others to checks."""
        self._occupied = set(device_ids)
        self._changed.set()
        self._changed = asyncio.Event()

    async def left(self, device_id: str, seconds: float) -> bool:
        """Does no job have this device that is ready, now or within so many seconds? Until the caller waits again."""
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                await self._until_left(device_id)
        return device_id not in self._occupied

    async def _until_left(self, device_id: str) -> None:
        while device_id in self._occupied:
            await self._changed.wait()

    def distrusted(self, connection: Connection) -> set[str]:
        """The ready devices whose newest check failed."""
        devices = self._cluster.ready.values()
        failed = repository.failed(connection, [device.fingerprint for device in devices])
        return {device.id for device in devices if device.fingerprint in failed}

    def worked(self, device_ids: Collection[str]) -> None:
        """Jobs ended well on these devices."""
        for device_id in device_ids:
            self._lost.pop(device_id, None)

    async def lost(self, device_id: str, job_id: str, says: str) -> None:
        """A job failed because the device's process died again and again, or hung. That may be the job's own fault;
        after so many in a row the device is quarantined: it is distrusted, and checked."""
        lost = self._lost[device_id] = [*self._lost.get(device_id, []), (job_id, says)]
        if len(lost) < LOST_IN_A_ROW or (device := self._cluster.ready.get(device_id)) is None:
            return
        log.error("device quarantined", device=device_id, jobs=[job for job, _ in lost])
        del self._lost[device_id]
        now, rows = datetime.now(UTC), [_broken("jobs", job, said) for job, said in lost]
        await in_thread(self._kept, device, now, rows)
        self.ask(device_id)

    # One check

    async def _check(self, device: Found) -> None:
        try:
            await self._until_left(device.id)
            started = self.under_way[device.id] = datetime.now(UTC)
            log.info("stability check begun", device=device.id)
            rows = await self._sweep(device.id)
            failures = [row["says"] for row in rows if row["verdict"] == "failed"]
            if failures:
                log.warning("device failed its stability check", device=device.id, failed=len(failures), of=len(rows))
            else:
                log.info("device passed its stability check", device=device.id, cases=len(rows))
            while not await in_thread(self._kept, device, started, rows):
                await asyncio.sleep(RETRY_SECONDS)
        except DeviceGoneError:  # What the outcome before said of it holds.
            log.warning("stability check given up, the device is gone", device=device.id)
        finally:
            del self.under_way[device.id]

    async def _sweep(self, device_id: str) -> list[dict[str, Any]]:
        """The rows of all cases; of a check that could not be carried out a single one, which failed.

        Raises DeviceGoneError.
        """
        try:
            outcome = await self._cluster.ask(device_id, f"check-{new_id()}", worker.check_stability, device_id)
            return [StabilityRow.model_validate(row).model_dump() for row in outcome["rows"]]
        except KilledWorker as error:
            says = f"The process that checks {device_id} died {error.allowed_failures + 1} times."
        except DeviceGoneError:
            raise
        except Exception as error:
            log.exception("stability check broke off", device=device_id)
            says = f"The check could not be carried out: {error}"
        return [_broken("check", "as a whole", says)]

    def _kept(self, device: Found, started: datetime, rows: list[dict[str, Any]]) -> bool:
        try:
            with self._engine.begin() as connection:
                repository.add(connection, device, started, datetime.now(UTC), rows)
        except SQLAlchemyError as error:
            log.error("the database does not answer", error=str(error))
            return False
        return True


def _broken(group: str, case: str, says: str) -> dict[str, Any]:
    """A row of something else than a number that is wrong."""
    return StabilityRow(
        group=group, case=case, expected=None, got=None, deviation=None, unit="roundings", limit=None,
        verdict="failed", says=says, seconds=0.0,
    ).model_dump()  # fmt: skip
