"""What a job's devices are sent to do, for a time that is limited, and what it means when one does not come back."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Callable
from typing import Any, TypeVar

from distributed.scheduler import KilledWorker

from woodcock_server.cluster import Cluster
from woodcock_server.config import Settings

T = TypeVar("T")

RELEASED_SECONDS = 0.5


class RenderError(RuntimeError):
    """The job cannot be finished; the text says why, for the one who asked for it."""


class DeviceLostError(RenderError):
    """A device's process died again and again, or is still out on an errand (hangs)."""

    def __init__(self, device: str, says: str, *, hangs: bool) -> None:
        super().__init__(says)
        self.device, self.hangs = device, hangs


class Errands:
    """The functions of worker.py that a job's devices run.

    scene: JSON, whose files are paths.
    """

    scene: str

    def __init__(self, cluster: Cluster, name: str, settings: Settings) -> None:
        """name: of no other job and attempt."""
        self._cluster, self._settings = cluster, settings
        self._keys = (f"{name}-{number}" for number in itertools.count())

    def send(self, device: str, what: str, function: Callable[..., Any], *args: Any) -> asyncio.Task[Any]:
        """Let a device run a function, after all that it was sent to do before. The task raises DeviceLostError,
        DeviceGoneError."""
        return asyncio.create_task(self._run(device, what, function, *args), name=what)

    async def _run(self, device: str, what: str, function: Callable[..., Any], *args: Any) -> Any:
        """Dask runs it again when its worker dies, so many times."""
        try:
            return await self._cluster.ask(device, next(self._keys), function, self.scene, device, *args)
        except KilledWorker as error:
            deaths = error.allowed_failures + 1
            # Of its own host, which may be another.
            memory = f"It is killed when it takes more than {error.last_worker.memory_limit >> 20} MiB."
            says = f"The process that renders on {device} died {deaths} times while {what}. {memory}"
            raise DeviceLostError(device, says, hangs=False) from None

    async def in_time(self, device: str, task: asyncio.Task[T]) -> T:
        """What comes of the first thing that a device has to do. Raises DeviceLostError if it takes too long."""
        try:
            async with asyncio.timeout(self._settings.range_seconds) as limit:
                return await task
        except TimeoutError:
            if not limit.expired():
                raise
        within = f"within {self._settings.range_seconds:g} s"
        says = f"{device} did not end {task.get_name()} {within}, and its process was killed."
        raise DeviceLostError(device, says, hangs=True)

    async def kill(self, device: str) -> None:
        """The process of a device that hangs; nobody may wait for anything that it was sent to do."""
        # What is not wanted any more is told to the scheduler some milliseconds later. What it still knew of would be
        # sent to the new process at once, and hang there.
        await asyncio.sleep(RELEASED_SECONDS)
        await self._cluster.restart(device)
