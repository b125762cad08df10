"""Takes jobs out of the queue, the oldest first and one at a time, under a lease that others can see run out."""

from __future__ import annotations

import asyncio
import os
import socket
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime, timedelta
from functools import partial

import structlog
from sqlalchemy import Connection, Engine
from sqlalchemy.exc import SQLAlchemyError

from woodcock.denoise import DenoiseError
from woodcock.device import DeviceError
from woodcock.formats import VolumeError
from woodcock.image import ImageError
from woodcock.scene import SceneError
from woodcock_server.claim import Claim, LeaseLost
from woodcock_server.cluster import Cluster
from woodcock_server.config import Settings
from woodcock_server.devices.checks import Checks
from woodcock_server.devices.choice import ANY, leaves_a_choice, meant
from woodcock_server.errands import DeviceLostError, RenderError
from woodcock_server.events import Changes, wait
from woodcock_server.jobs import repository
from woodcock_server.metrics import Metrics
from woodcock_server.rendering import Rendering
from woodcock_server.storage import Storage
from woodcock_server.threads import in_thread

log = structlog.get_logger()

#: How often the queue is looked at for jobs of other servers, and leases that ran out, seconds.
LOOK_EVERY = 1.0


class Dispatcher:
    """Renders the queue's jobs on a cluster's devices."""

    def __init__(
        self,
        engine: Engine,
        storage: Storage,
        changes: Changes,
        cluster: Cluster,
        checks: Checks,
        settings: Settings,
        metrics: Metrics,
    ) -> None:
        self._engine, self._storage, self._changes = engine, storage, changes
        self._cluster, self._checks = cluster, checks
        self._lease, self._settings, self._metrics = timedelta(seconds=settings.lease_seconds), settings, metrics
        self._holder = f"{socket.gethostname()}:{os.getpid()}"
        self._work, self._look = asyncio.Event(), asyncio.Event()
        self._task: asyncio.Task[None] | None = None
        self.at_work: dict[str, str] = {}  # device id -> the job that it renders

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Render in the background; at the end, put a job that is not finished back into the queue."""
        if not (
            self._cluster.ready or self._cluster.remote
        ):  # What is asked for waits in the queue, for a server that can render.
            yield
            return
        self._begin()
        try:
            yield
        finally:
            assert self._task is not None
            self._task.remove_done_callback(self._begin_again)
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task

    def _begin(self) -> None:
        self._task = asyncio.create_task(self._run(), name="dispatcher")
        self._task.add_done_callback(self._begin_again)

    def _begin_again(self, ended: asyncio.Task[None]) -> None:
        """Nobody asked it to end: what it waited for was cancelled by somebody else, and so was it."""
        log.error("the dispatcher broke off and begins again", cancelled=ended.cancelled())
        self._begin()

    def wake(self) -> None:
        """There is a new job."""
        self._work.set()

    def look(self) -> None:
        """A job is to be cancelled; perhaps it is the one that is rendered."""
        self._look.set()

    def fault(self, connection: Connection) -> str | None:
        """Why nothing is rendered, jobs that ask for a device perhaps excepted; None if something is."""
        if self._stopped:
            return self._stopped
        if self._checks.distrusted(connection).issuperset(self._cluster.ready):
            return (
                "Every device that is ready failed its stability check, and renders only jobs that ask for it by "
                "its id; /api/v1/devices says what failed."
            )
        return None

    def hindrance(self, connection: Connection, asked: str) -> str | None:
        """Why a job that asks for this device, or for any, would not be rendered even if it were the only one."""
        if fault := self._stopped if asked != ANY else self.fault(connection):
            return fault
        able = {device.id for device in meant(asked, self._cluster.ready.values())}
        if leaves_a_choice(asked):
            able -= self._checks.distrusted(connection)
        if not able:
            return f"It asks for {asked}, which is not ready on this server; /api/v1/devices says why."
        if able.issubset(self._checks.under_way):
            return f"It waits for the stability check of {' and '.join(sorted(able))}."
        return None

    @property
    def _stopped(self) -> str | None:
        if fault := self._cluster.fault:
            return fault
        if self._task is None or self._task.done():
            return "The dispatcher has stopped; the server's log says why."
        return None

    async def _run(self) -> None:
        while True:
            try:
                if not await self._take_one():
                    await wait(self._work, LOOK_EVERY)
            except SQLAlchemyError as error:
                # The job stays under its lease, and is claimed again from its checkpoint when that has run out.
                log.error("the database does not answer", error=str(error))
                await asyncio.sleep(LOOK_EVERY)
            except Exception:  # One job's trouble must not be the end of all.
                log.exception("the dispatcher stumbled")
                await asyncio.sleep(LOOK_EVERY)

    async def _take_one(self) -> bool:
        """Render the job that is next, on those of the devices that it may have; False if there is none."""
        free = self._checks.free
        self._checks.occupy(free)
        try:
            claimed = await in_thread(self._claim, free)
            if claimed is None:
                return False
            row, devices = claimed
            self._metrics.claimed(row, datetime.now(UTC))
            self._checks.occupy(devices)
            claim = Claim(self._engine, self._storage, self._changes, row)
            self.at_work = dict.fromkeys(devices, claim.id)
            job = Rendering(
                claim,
                self._storage,
                self._cluster,
                devices,
                partial(self._recruit, row["device"]),
                self._metrics,
                self._settings,
            )
            with structlog.contextvars.bound_contextvars(job=claim.id):
                try:
                    await self._attempt(job)
                except LeaseLost:
                    if await claim.let_go():
                        log.info("job cancelled")
                    else:
                        log.warning("job lost to another dispatcher")
            return True
        finally:
            self.at_work = {}
            self._checks.occupy(())

    def _claim(self, free: Sequence[str]) -> tuple[repository.Row, list[str]] | None:
        """A job and the devices that render it: all that are trusted, those of a kind, or the one that it asks for,
        trusted or not."""
        now = datetime.now(UTC)
        self._cancel_abandoned(now)
        ready = {id: device for id, device in self._cluster.ready.items() if id in free}
        with self._engine.connect() as connection:
            distrusted = self._checks.distrusted(connection)
            trusted = {id: device for id, device in ready.items() if id not in distrusted}
            asks = {ask for device in trusted.values() for ask in (ANY, device.device.kind)}
            job_id = repository.next_claimable(connection, now, {*ready, *asks})
        if job_id is None:
            return None
        with self._engine.begin() as connection:
            row = repository.claim(connection, job_id, self._holder, now, self._lease)
        if row is None:
            return None
        able = trusted if leaves_a_choice(row["device"]) else ready
        return row, [device.id for device in meant(row["device"], able.values())]

    async def _recruit(self, asked: str) -> list[str]:
        """The devices that a job which asks for this one may have by now; it has them from then on. Those that it had
        stay, whatever came to be known of them."""

        def distrusted() -> set[str]:
            with self._engine.connect() as connection:
                return self._checks.distrusted(connection)

        shut = await in_thread(distrusted) - self.at_work.keys() if leaves_a_choice(asked) else set()
        open_to_it = {*self._checks.free, *self.at_work} - shut
        there = [device for id, device in self._cluster.ready.items() if id in open_to_it]
        able = [device.id for device in meant(asked, there)]
        self.at_work |= dict.fromkeys(able, next(iter(self.at_work.values())))
        self._checks.occupy(self.at_work)
        return able

    def _cancel_abandoned(self, now: datetime) -> None:
        with self._engine.connect() as connection:
            abandoned = repository.abandoned(connection, now)
        for job_id, token in abandoned:
            with self._engine.begin() as connection:
                cancelled = repository.let_go(connection, job_id, token, now)
            if cancelled:
                log.warning("job cancelled, its holder is gone", job=job_id)
                self._storage.drop_checkpoints(job_id, token + 1)
                self._storage.unstage(job_id, token)

    async def _attempt(self, job: Rendering) -> None:
        rendering = asyncio.create_task(job.run())
        lease = asyncio.create_task(self._keep_lease(job))
        try:
            await asyncio.wait({rendering, lease}, return_when=asyncio.FIRST_COMPLETED)
            if lease.done():
                await _end(rendering)
                lease.result()
            rendering.result()
            self._checks.worked(job.devices)
        except asyncio.CancelledError:
            await _end(rendering)
            try:
                await job.put_back()
            except Exception as error:  # Its lease runs out instead.
                log.warning("job not put back", reason=repr(error))
            raise
        except DeviceLostError as error:
            await self._checks.lost(error.device, job.claim.id, str(error))
            await job.fail(str(error))
        except (RenderError, DeviceError, VolumeError, ImageError, SceneError, DenoiseError) as error:
            await job.fail(str(error))
        except (LeaseLost, SQLAlchemyError):
            raise
        except Exception as error:
            if lease.done():  # Whatever kept the lease from being renewed, it says nothing of the job.
                raise
            log.exception("rendering broke off")
            await job.fail(f"The renderer stopped unexpectedly: {type(error).__name__}: {error}")
        finally:
            await _end(lease)

    async def _keep_lease(self, job: Rendering) -> None:
        """Renew the lease until cancelled. Raises LeaseLost."""
        while True:
            await wait(self._look, 0.3 * self._lease.total_seconds())
            # One that is leaving finds out by itself, and its lease is gone because it left.
            if not await in_thread(self._renew, job.claim) and not job.claim.leaving:
                raise LeaseLost

    def _renew(self, claim: Claim) -> bool:
        with self._engine.begin() as connection:
            values = {"lease_until": datetime.now(UTC) + self._lease}
            return repository.write_held(connection, claim.id, claim.token, values)


async def _end(task: asyncio.Task[None]) -> None:
    """Cancel a task and wait until it is over, whatever it ends with."""
    task.cancel()
    await asyncio.wait({task})
    if not task.cancelled():
        task.exception()
