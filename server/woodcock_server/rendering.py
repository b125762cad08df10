"""One job, from its claim to its picture: pieces out to every device, Films back, checkpoints on the way."""

from __future__ import annotations

import asyncio
import math
import time
from collections import deque
from collections.abc import Awaitable, Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any, TypeAlias, TypeVar

import structlog
from pydantic import ValidationError

from woodcock import series
from woodcock.denoise import require
from woodcock.device import DeviceError
from woodcock.film import Film
from woodcock.reference import Reference
from woodcock.report import Use
from woodcock.scene import Scene, SceneError, explain, files, with_files
from woodcock_server import results, worker
from woodcock_server.books import Books
from woodcock_server.claim import Claim
from woodcock_server.cluster import DEATHS_ALLOWED, Cluster, DeviceGoneError
from woodcock_server.config import Settings
from woodcock_server.errands import DeviceLostError, Errands
from woodcock_server.jobs import reference
from woodcock_server.jobs.states import State
from woodcock_server.metrics import Metrics
from woodcock_server.ranges import LONGEST_SECONDS
from woodcock_server.results import UNWRITTEN
from woodcock_server.rounds import Rounds
from woodcock_server.storage import Storage, StoreAway
from woodcock_server.threads import in_thread

log = structlog.get_logger()

PROGRESS_SECONDS = 1.0  # between previews and writes of the row
CHECKPOINT_SECONDS = 2.0  # between writes of the Film: what a crash may cost
WRITING = 9.0  # large pictures: so many times what writing took passes before the next, a tenth of the time goes there
WRITE_AGAIN_SECONDS = 2.0  # after the disk did not take what the job cannot do without

#: Before a device that is gone is looked for again.
AGAIN_SECONDS = 1.0

#: The devices that a job may have as of now.
Recruit: TypeAlias = Callable[[], Awaitable[Sequence[str]]]
#: As `worker.render_range` returns it.
Rendered: TypeAlias = tuple[Film, float, str]
T = TypeVar("T")


class Rendering:
    """A claimed job being rendered by every device of a cluster."""

    def __init__(
        self,
        claim: Claim,
        storage: Storage,
        cluster: Cluster,
        devices: Sequence[str],
        recruit: Recruit,
        metrics: Metrics,
        settings: Settings,
    ) -> None:
        self.claim, row, self.devices = claim, claim.row, list(devices)
        self._cluster, self._recruit = cluster, recruit
        self._storage, self._metrics = storage, metrics
        self._errands = Errands(cluster, f"{claim.id}-{claim.token}", settings)
        self._longest = min(LONGEST_SECONDS, settings.range_seconds / 4)
        self._film: Film | None = None
        self._reference: Reference | None = None
        self._books = Books(row)
        self._faults: list[DeviceError] = []
        self._left: dict[str, int] = {}  # device -> how often it was gone since it rendered something
        self._timed_out = False
        self._merging = asyncio.Lock()
        self._claimed_at = time.monotonic()
        self._turn = asyncio.Event()  # the next round has begun
        # Rendering time so far: of former attempts, and since this one's first device was ready.
        self._before: float = row["seconds"]
        self._since: float | None = None
        self._progress_at = self._checkpoint_at = -math.inf

    @property
    def seconds(self) -> float:
        return self._before + (time.monotonic() - self._since if self._since is not None else 0.0)

    @property
    def samples(self) -> int:
        return self._film.samples if self._film else 0

    async def run(self) -> None:
        """Render what is missing and publish the picture. Raises LeaseLost, RenderError, what the renderer raises."""
        with ExitStack() as held:
            await self._render(held)

    async def _render(self, held: ExitStack) -> None:
        """held: gets what must stay for as long as the job is rendered."""
        self._read_scene()
        if self._scene.denoise:
            await in_thread(require)
        stays = partial(self._cluster.files, files(self._scene))
        where = await self._until_written(lambda: in_thread(held.enter_context, stays()))
        local = with_files(self._scene, lambda file: str(where[file]))
        self._errands.scene = local.model_dump_json()
        if named := self.claim.row["reference"]:
            found = await self._until_written(partial(in_thread, reference.load, self._storage, named))
            self._reference = found.independent_of(self._scene.seed)
        await self._resume()
        kept = self.samples
        log.info("job claimed", token=self.claim.token, samples_kept=kept)
        self._rounds = await in_thread(Rounds, self._scene, self.devices, self._film, self._longest)
        try:
            await self._drive_all()
        except ExceptionGroup as errors:
            first = errors.exceptions[0]
            if isinstance(first, DeviceLostError) and first.hangs:
                await self._errands.kill(first.device)
            raise first from None
        if self._film is None or not (self._rounds.over or self._timed_out):
            raise self._faults[0]
        await self._finish(self._film)
        log.info("job succeeded", samples=self.samples, samples_rendered=self.samples - kept)

    def _read_scene(self) -> None:
        try:
            self._scene = Scene.model_validate(self.claim.row["scene"])
        except ValidationError as error:  # Committed by another version of this program.
            raise SceneError(explain(error.errors(include_url=False))) from None

    async def _resume(self) -> None:
        """Go on from the checkpoint, with what the row says of it."""
        self._film = await self._until_written(self.claim.resume)
        if self._film is not None:
            self._books.resume(self._film)
        # The row may have counted samples that no checkpoint held.
        await self.claim.write({"samples": self.samples})

    # Handing out and merging

    async def _drive_all(self) -> None:
        """Drive the devices that are there, and those that come, or come back, until the contract is met or none can
        render the scene."""
        drives: dict[str, asyncio.Task[bool]] = {}
        ended, away = set[str](), set(self.devices)
        changed: asyncio.Task[None] | None = None
        async with asyncio.TaskGroup() as group:
            while True:
                if changed is None or changed.done():  # At first, too: they may be others than those of the claim.
                    changed = group.create_task(self._cluster.changed())
                    present = await self._recruit()
                    self.devices += [device for device in present if device not in self.devices]
                for device in set(present) - drives.keys() - ended:
                    away.discard(device)
                    self._rounds.join(device)
                    drives[device] = group.create_task(self._drive(device))
                finished = self._rounds.over or (self._timed_out and self._film is not None)
                if not drives and (finished or not away):
                    break
                await asyncio.wait({changed, *drives.values()}, return_when=asyncio.FIRST_COMPLETED)
                for device, drive in list(drives.items()):
                    if drive.done():
                        del drives[device]
                        (ended if drive.result() else away).add(device)
            changed.cancel()

    async def _drive(self, device: str) -> bool:
        """Render on a device until there is no more for it to do; False where it left, and may come back."""
        try:
            if await self._prepare(device):
                await self._feed(device)
        except (DeviceGoneError, StoreAway) as error:  # It may come back, or its files may.
            log.warning("device left the job", device=device, reason=str(error))
            self._rounds.leave(device)
            self._begin_turn()  # for those who wait for the pieces that it had
            self._left[device] = self._left.get(device, 0) + isinstance(error, DeviceGoneError)
            if self._left[device] > DEATHS_ALLOWED:
                self._faults.append(DeviceError(f"{device} was gone {self._left[device]} times before it rendered."))
                return True
            await asyncio.sleep(AGAIN_SECONDS)
            return False
        return True

    async def _feed(self, device: str) -> None:
        """Keep one piece running and one waiting on a device. Raises DeviceGoneError."""
        pieces: deque[asyncio.Task[Rendered]] = deque()
        try:
            while not self._rounds.over:
                self._hand_out(device, pieces)
                if pieces:
                    film, seconds, program = await self._errands.in_time(device, pieces[0])
                    pieces.popleft()
                    self._rounds.rendered(device, seconds)
                    self._left.pop(device, None)
                    self._hand_out(device, pieces)
                    await self._merge(device, film, seconds, program)
                elif self._rounds.timed_out:
                    self._timed_out = True
                    return
                else:  # Others render the last pieces of the round.
                    await self._turn.wait()
        finally:
            for task in pieces:
                task.cancel()
            await asyncio.gather(*pieces, return_exceptions=True)

    def _hand_out(self, device: str, pieces: deque[asyncio.Task[Rendered]]) -> None:
        while piece := self._rounds.take(device, self.seconds):
            what = f"rendering samples {piece.start} to {piece.stop - 1}"
            part = piece.start, piece.stop, piece.pixels
            pieces.append(self._errands.send(device, what, worker.render_range, *part))

    async def _prepare(self, device: str) -> bool:
        """Make the scene ready on a device; False where that cannot render it."""
        try:
            # Another program would count for the variant that is compared.
            own = self.claim.row["comparison"] is not None
            preparing = self._errands.send(device, "preparing the scene", worker.prepare, own)
            facts, found = await self._errands.in_time(device, preparing)
        except DeviceError as error:
            log.warning("device left out", device=device, reason=str(error))
            self._faults.append(error)
            return False
        self._books.prepared(device, facts)
        self._metrics.prepared(found, facts["seconds"])
        if self._since is None:
            self._since = time.monotonic()
        return True

    async def _merge(self, device: str, film: Film, seconds: float, program: str) -> None:
        async with self._merging:
            began = time.monotonic()
            with self._timing("merge"):
                self._film = await in_thread(self._film.merge, film) if self._film else self._checked(film)
            took = time.monotonic() - began
            self._books.rendered(device, film, seconds, program)
            self._metrics.rendered(device, int(film.count.sum()), seconds)
            if series.due(self._books.series, self._film):
                await self._measure(self._film)
            if time.monotonic() - self._progress_at >= PROGRESS_SECONDS:
                await self._record(self._film)
            if self._rounds.merged(took):
                await in_thread(self._rounds.begin, self._film)
                self._begin_turn()

    def _begin_turn(self) -> None:
        """There may be pieces for those who have none."""
        self._turn.set()
        self._turn = asyncio.Event()

    def _checked(self, film: Film) -> Film:
        """The first: its channels are known now, and with them whether it can be held against the reference."""
        if self._reference is not None:
            self._reference.check(film.width, film.height, film.channels)
        return film

    @contextmanager
    def _timing(self, stage: str) -> Iterator[None]:
        began = time.monotonic()
        try:
            yield
        finally:
            seconds = time.monotonic() - began
            self._books.spent[stage] += seconds
            self._metrics.spent({stage: seconds})

    # Writing down

    async def _measure(self, film: Film) -> None:
        """The next point of the error series, once the error can be estimated."""
        with self._timing("check"):
            point = await in_thread(series.measure, film, self.seconds, self._books.device_seconds, self._reference)
        if point is not None:
            self._books.series.append(point)

    async def _record(self, film: Film) -> None:
        """Preview and row, and the Film when it is time: the row counts no samples of which there is no preview."""
        began = time.monotonic()
        values = await in_thread(results.figures, self._scene, film, self.seconds)
        try:
            with self._timing("write"):
                await in_thread(results.preview, await self.claim.stage(), film)
                if self._progress_at == -math.inf and self.claim.token == 1:
                    self._metrics.first_preview.observe(time.monotonic() - self._claimed_at)
                # Before the checkpoint, so that nobody waits for the preview longer.
                await self.claim.write(values, publish=True)
                if time.monotonic() - self._checkpoint_at >= CHECKPOINT_SECONDS:
                    await self._save(film)
        except UNWRITTEN as error:  # The next ones may be; the Film is in memory.
            log.warning("progress not written", reason=str(error))
        self._progress_at = time.monotonic() + WRITING * (time.monotonic() - began)

    async def _save(self, film: Film) -> None:
        """The checkpoint, and first what the row says of it."""
        began = time.monotonic()
        await self.claim.write({**self._books.columns(), "seconds": self.seconds})
        await self.claim.keep(film)
        self._books.kept(film)
        self._checkpoint_at = time.monotonic() + WRITING * (time.monotonic() - began)

    async def _until_written(self, write: Callable[[], Awaitable[T]]) -> T:
        """For what the job cannot go on without, and must not fail for: samples are dearer than time."""
        while True:
            try:
                # Its folder is there then, and rid of what could not be removed from a disk that was read-only.
                await in_thread(self._storage.open_job, self.claim.id)
                return await write()
            except UNWRITTEN as error:
                log.error("the files are out of reach; trying again", reason=str(error))
                await asyncio.sleep(WRITE_AGAIN_SECONDS)

    # Ends

    async def _finish(self, film: Film) -> None:
        values = await in_thread(results.figures, self._scene, film, self.seconds)
        points = self._books.series
        if not points or film.mean_samples > points[-1]["samples"]:
            await self._measure(film)
        with self._timing("write"):
            await self._until_written(partial(self._save, film))
            await self.claim.write(values)
        with self._timing("check"):
            uses = [await self._certified(device, use) for device, use in self._books.usage.items() if use["samples"]]
        seconds = {"render": values["seconds"], **self._books.spent}
        with self._timing("write"):
            report = await self._until_written(partial(self._publish, film, uses, points, seconds))
        self._metrics.succeeded(report)

    async def _publish(
        self, film: Film, uses: Sequence[Use], points: Sequence[series.Point], seconds: Mapping[str, float]
    ) -> dict[str, Any]:
        """Picture and report, and the end of the job with them; returns the report."""
        staged, name = await self.claim.stage(), self.claim.row["name"]
        report = await in_thread(results.write, staged, name, self._scene, film, uses, points, seconds, self._reference)
        await self.claim.end(State.SUCCEEDED)
        return report

    async def _certified(self, device: str, use: Use) -> Use:
        """As of the scene's own program, which may have come late, and with the evidence for the certificate; a device
        that cannot give it any more has rendered all the same."""
        if device not in self.devices:  # It was another attempt's.
            return use
        try:
            facts, evidence = await self._errands.send(device, "checking the program", worker.certify)
            return {**use, **facts, "id": device, "evidence": evidence}
        except Exception as error:
            log.warning("no evidence for the certificate", device=device, reason=repr(error))
            return use

    async def fail(self, sentence: str) -> None:
        """End the job with what went wrong, files named as the job names them. Raises LeaseLost."""
        sentence = self._storage.by_id(sentence)
        log.warning("job failed", error=sentence)
        await self.claim.end(State.FAILED, sentence)
        self._metrics.finished.labels("failed").inc()

    async def put_back(self) -> None:
        """Keep what is rendered and leave the job to the next dispatcher. Raises LeaseLost."""
        values: dict[str, Any] = {"seconds": self.seconds}
        if self._film is not None:
            try:
                await self._save(self._film)
                values["samples"] = self.samples
            except UNWRITTEN as error:  # The one before it is there.
                log.warning("checkpoint not written", reason=str(error))
        await self.claim.put_back(values)
        log.info("job put back", samples_kept=self.samples)
