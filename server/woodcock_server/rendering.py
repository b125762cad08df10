"""One job, from its claim to its picture: ranges out to every device, Films back, checkpoints on the way."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import Any, ParamSpec, TypeVar

import structlog
from distributed import Client
from distributed.scheduler import KilledWorker
from pydantic import ValidationError
from sqlalchemy import Engine, RowMapping

from woodcock.denoise import require
from woodcock.device import DeviceError
from woodcock.film import Film, FilmError
from woodcock.pace import Pace, fit
from woodcock.report import SERIES_GROWTH, Facts, Point, Use, point
from woodcock.scene import SamplesStop, Scene, SceneError, explain, with_files
from woodcock_server import results, worker
from woodcock_server.cluster import resource
from woodcock_server.events import Changes
from woodcock_server.jobs import repository
from woodcock_server.jobs.schemas import State
from woodcock_server.ranges import Pool, share
from woodcock_server.storage import Storage

log = structlog.get_logger()

PROGRESS_SECONDS = 1.0  # between previews and writes of the row
CHECKPOINT_SECONDS = 2.0  # between writes of the Film: what a crash may cost
MOST_SAMPLES = 1 << 31

P = ParamSpec("P")
T = TypeVar("T")


class LeaseLost(Exception):  # noqa: N818 - it says what happened
    """Another dispatcher holds the job now; whatever this one still does must leave no trace."""


class RenderError(RuntimeError):
    """The job cannot be finished; the text says why, for the one who asked for it."""


async def in_thread(function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """asyncio.to_thread that ends before it is cancelled: two writers of one file never meet."""
    task = asyncio.create_task(asyncio.to_thread(function, *args, **kwargs))
    try:
        return await asyncio.shield(task)
    except asyncio.CancelledError:
        await asyncio.wait({task})
        raise


class Rendering:
    """A claimed job being rendered by every device of a cluster."""

    def __init__(
        self,
        engine: Engine,
        storage: Storage,
        changes: Changes,
        client: Client,
        devices: Sequence[str],
        row: RowMapping,
    ) -> None:
        self.id: str = row["id"]
        self.token: int = row["token"]
        self._engine, self._storage, self._changes, self._client, self._devices = (
            engine, storage, changes, client, devices,
        )  # fmt: skip
        self._row = row
        self._film: Film | None = None
        self._usage: dict[str, Use] = row["usage"]
        self._series: list[Point] = row["series"]
        self._paces = {device: Pace() for device in devices}
        self._faults: list[DeviceError] = []
        self._merging = asyncio.Lock()
        # Rendering time so far: of former attempts, and since this one's first device was ready.
        self._spent: float = row["seconds"]
        self._since: float | None = None
        self._progress_at = self._checkpoint_at = -math.inf

    @property
    def seconds(self) -> float:
        return self._spent + (time.monotonic() - self._since if self._since is not None else 0.0)

    @property
    def samples(self) -> int:
        return self._film.samples if self._film else 0

    async def run(self) -> None:
        """Render what is missing and publish the picture. Raises LeaseLost, RenderError, what the renderer raises."""
        self._read_scene()
        if self._scene.denoise:
            await in_thread(require)
        await self._resume()
        stop = self._scene.stop
        end = stop.samples if isinstance(stop, SamplesStop) else MOST_SAMPLES
        self._pool = Pool(self._film.ranges if self._film else (), end)
        kept = self.samples
        log.info("job claimed", job=self.id, token=self.token, samples_kept=kept)
        try:
            async with asyncio.TaskGroup() as group:
                for device in self._devices:
                    group.create_task(self._drive(device))
        except ExceptionGroup as errors:
            raise errors.exceptions[0] from None
        if self._film is None or (isinstance(stop, SamplesStop) and self.samples < stop.samples):
            raise self._faults[0]
        await self._finish(self._film)
        log.info("job succeeded", job=self.id, samples=self.samples, samples_rendered=self.samples - kept)

    def _read_scene(self) -> None:
        try:
            self._scene = Scene.model_validate(self._row["scene"])
        except ValidationError as error:  # Committed by another version of this program.
            raise SceneError(explain(error.errors(include_url=False))) from None
        local = with_files(self._scene, lambda file: str(self._storage.volume_file(file)))
        self._text = local.model_dump_json()

    async def _resume(self) -> None:
        await in_thread(self._storage.open_job, self.id)
        if path := await in_thread(self._storage.newest_checkpoint, self.id):
            try:
                self._film = await in_thread(Film.load, path)
            except FilmError as error:
                log.error("checkpoint lost, starting again", job=self.id, reason=str(error))
        # The row may have counted samples that no checkpoint held.
        self._series = [one for one in self._series if one["samples"] <= self.samples]
        await self._write({"samples": self.samples})

    # Handing out and merging

    async def _drive(self, device: str) -> None:
        """Keep one range running and one waiting on a device, until there is no more to do."""
        try:
            facts: Facts = await self._ask(device, "prepare", "preparing the scene")
        except DeviceError as error:
            log.warning("device left out", job=self.id, device=device, reason=str(error))
            self._faults.append(error)
            return
        before = self._usage.get(device)
        self._usage[device] = {
            **facts,
            "samples": before["samples"] if before else 0,
            "render_seconds": before["render_seconds"] if before else 0.0,
            "evidence": None,
        }
        if self._since is None:
            self._since = time.monotonic()

        waiting: list[tuple[int, int, asyncio.Task[Any]]] = []
        try:
            while True:
                while len(waiting) < 2 and (count := self._count(device, waiting)):
                    start, stop = self._pool.take(count)
                    what = f"rendering samples {start} to {stop - 1}"
                    waiting.append(
                        (start, stop, asyncio.create_task(self._ask(device, "render_range", what, start, stop)))
                    )
                if not waiting:
                    return
                start, stop, task = waiting.pop(0)
                film, seconds = await task
                self._paces[device].measured(stop - start, seconds)
                await self._merge(device, film, seconds)
        finally:
            for _, _, task in waiting:
                task.cancel()
            await asyncio.gather(*(task for _, _, task in waiting), return_exceptions=True)

    def _count(self, device: str, waiting: Sequence[tuple[int, int, Any]]) -> int:
        """Samples of the device's next range; 0 for none now."""
        left, pace, stop = self._pool.left, self._paces[device], self._scene.stop
        if isinstance(stop, SamplesStop):
            return share(pace, left, sum(other.rate for other in self._paces.values())) if left else 0
        ahead = sum(last - first for first, last, _ in waiting)
        if pace.rate == 0 and ahead:  # One sample tells how long a second would take.
            return 0
        seconds = stop.seconds - self.seconds - (ahead / pace.rate if ahead else 0.0)
        return min(left, fit(pace, seconds, nothing_yet=left == MOST_SAMPLES))

    async def _ask(self, device: str, function: str, what: str, *args: int) -> Any:
        """Run a function of worker.py on a device. Dask runs it again when its worker dies, so many times."""
        future = self._client.submit(
            getattr(worker, function), self._text, device, *args,
            key=f"{self.id}-{self.token}-{device}-{function}-{args}", resources=resource(device), pure=False,
        )  # fmt: skip
        try:
            return await future
        except KilledWorker as error:
            deaths = error.allowed_failures + 1
            raise RenderError(f"The process that renders on {device} died {deaths} times while {what}.") from None
        finally:
            future.release()  # type: ignore[no-untyped-call]

    async def _merge(self, device: str, film: Film, seconds: float) -> None:
        async with self._merging:
            self._film = film if self._film is None else await in_thread(self._film.merge, film)
            self._usage[device]["samples"] += film.samples
            self._usage[device]["render_seconds"] += seconds
            if not self._series or self.samples >= self._series[-1]["samples"] * SERIES_GROWTH:
                await self._measure(self._film)
            if time.monotonic() - self._progress_at >= PROGRESS_SECONDS:
                await self._record(self._film)

    # Writing down

    async def _measure(self, film: Film) -> None:
        """The next point of the error series, once the error can be estimated."""
        if (measured := await in_thread(point, self.seconds, film)) is not None:
            self._series.append(measured)

    async def _record(self, film: Film) -> None:
        """Preview and row, and the Film when it is time: the row counts no samples of which there is no preview."""
        values = await self._figures(film)
        await in_thread(results.preview, self._storage, self.id, film)
        if time.monotonic() - self._checkpoint_at >= CHECKPOINT_SECONDS:
            values |= await self._save(film)
        await self._write(values)
        self._progress_at = time.monotonic()

    async def _figures(self, film: Film) -> dict[str, Any]:
        rmse = await in_thread(film.rmse)
        mean = await in_thread(film.mean_luminance)
        known = math.isfinite(rmse)
        return {
            "samples": film.samples,
            "seconds": self.seconds,
            "rmse": rmse if known else None,
            "relative_rmse": rmse / mean if known and mean > 0 else None,
        }

    async def _save(self, film: Film) -> dict[str, Any]:
        began = time.monotonic()
        await in_thread(film.save, self._storage.checkpoint(self.id, self.token))
        await in_thread(self._storage.drop_checkpoints, self.id, self.token)
        # A large Film takes long to write: no more than a tenth of the time goes into that.
        self._checkpoint_at = time.monotonic() + 9 * (time.monotonic() - began)
        return {"usage": self._usage, "series": self._series}

    async def _write(self, values: dict[str, Any]) -> None:
        if not await in_thread(self._write_held, values):
            raise LeaseLost
        self._changes.publish(self.id)

    def _write_held(self, values: dict[str, Any]) -> bool:
        with self._engine.begin() as connection:
            return repository.write_held(connection, self.id, self.token, values)

    # Ends

    async def _finish(self, film: Film) -> None:
        values = await self._figures(film)
        if not self._series or film.samples > self._series[-1]["samples"]:
            await self._measure(film)
        await self._write(values | await self._save(film))
        began = time.monotonic()
        uses = [await self._certified(device, use) for device, use in self._usage.items() if use["samples"]]
        seconds = {"render": values["seconds"], "check": time.monotonic() - began}
        await in_thread(results.write, self._storage, self.id, self._scene, film, uses, self._series, seconds)
        await self._write({"state": State.SUCCEEDED, "finished_at": datetime.now(UTC), **_NOBODY})
        await in_thread(self._storage.drop_checkpoints, self.id, self.token + 1)

    async def _certified(self, device: str, use: Use) -> Use:
        """With the evidence for the certificate; a device that cannot give it any more has rendered all the same."""
        if device not in self._devices:  # It was another attempt's.
            return use
        try:
            return {**use, "evidence": await self._ask(device, "certify", "checking the program")}
        except Exception as error:
            log.warning("no evidence for the certificate", job=self.id, device=device, reason=repr(error))
            return use

    async def fail(self, sentence: str) -> None:
        """End the job with what went wrong, files named as the job names them. Raises LeaseLost."""
        sentence = self._storage.by_id(sentence)
        log.warning("job failed", job=self.id, error=sentence)
        await self._write({"state": State.FAILED, "error": sentence, "finished_at": datetime.now(UTC), **_NOBODY})
        await in_thread(self._storage.drop_checkpoints, self.id, self.token + 1)

    async def put_back(self) -> None:
        """Keep what is rendered and leave the job to the next dispatcher. Raises LeaseLost."""
        values: dict[str, Any] = {"seconds": self.seconds}
        if self._film is not None:
            values |= {"samples": self.samples, **await self._save(self._film)}
        await self._write({"state": State.QUEUED, **values, **_NOBODY})
        log.info("job put back", job=self.id, samples_kept=self.samples)


_NOBODY: dict[str, Any] = {"owner": None, "lease_until": None}
