"""Submitting jobs and following them."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from datetime import UTC, datetime

from anyio import to_thread
from sqlalchemy import Engine, RowMapping

from woodcock.denoise import DenoiseError, require
from woodcock.scene import Scene
from woodcock_server.devices.service import Found
from woodcock_server.dispatcher import Dispatcher
from woodcock_server.events import Changes, wait
from woodcock_server.jobs import reference, repository
from woodcock_server.jobs.schemas import ANY, JobCreate, JobSummary, State, summary
from woodcock_server.problems import Fault, InvalidRequest
from woodcock_server.storage import Storage
from woodcock_server.volumes.check import check_scene

#: A job that another server renders announces nothing here: its row is looked at this often, seconds.
LOOK_EVERY = 2.0


def create(engine: Engine, storage: Storage, devices: Sequence[Found], request: JobCreate) -> RowMapping:
    """Commit a new job to the queue. Raises InvalidRequest."""
    check_request(engine, storage, devices, request)
    scene, now = request.scene.model_dump(mode="json"), datetime.now(UTC)
    with engine.begin() as connection:
        job_id = repository.add(connection, request.name, scene, request.device, now, request.reference)
    row = find(engine, job_id)
    assert row is not None, "jobs are never deleted"
    return row


def check_request(engine: Engine, storage: Storage, devices: Sequence[Found], request: JobCreate) -> None:
    """Raises InvalidRequest for what cannot be rendered here."""
    _check_device(devices, request.device)
    check_scene(engine, request.scene)
    _check_denoiser(request.scene)
    if request.reference is not None:
        reference.check(engine, storage, request.scene, request.reference)


def _check_device(devices: Sequence[Found], asked: str) -> None:
    """Raises InvalidRequest for a device that there is not, or that cannot be used."""
    known = {device.id: device for device in devices}
    if asked == ANY:
        return
    if asked not in known:
        message = f"must be {ANY} or the id of a device of this server: {', '.join(known) or 'there is none'}"
    elif not known[asked].ready:
        message = f"{asked} cannot be used: {known[asked].probe.fault}"
    else:
        return
    raise InvalidRequest("The job cannot have the device that it asks for.", Fault(field="device", message=message))


def _check_denoiser(scene: Scene) -> None:
    """Raises InvalidRequest for a scene whose picture could not be denoised here."""
    try:
        if scene.denoise:
            require()
    except DenoiseError as error:
        fault = Fault(field="scene.denoise", message=str(error))
        raise InvalidRequest("The picture cannot be denoised by this service.", fault) from None


def find(engine: Engine, job_id: str) -> RowMapping | None:
    with engine.connect() as connection:
        return repository.get(connection, job_id)


def waiting(engine: Engine, dispatcher: Dispatcher, rows: Sequence[RowMapping]) -> list[str | None]:
    """Of each job why it would not be rendered even if no job were before it; None also for those that do not wait."""
    asked = {row["device"] for row in rows if row["state"] == State.QUEUED}
    with engine.connect() as connection:
        reasons = {device: dispatcher.hindrance(connection, device) for device in asked}
    return [reasons[row["device"]] if row["state"] == State.QUEUED else None for row in rows]


def look(engine: Engine, dispatcher: Dispatcher, job_id: str) -> JobSummary:
    """A job that exists, as it is now."""
    row = find(engine, job_id)
    assert row is not None, "jobs are never deleted"
    return summary(row, *waiting(engine, dispatcher, [row]))


async def follow(engine: Engine, changes: Changes, dispatcher: Dispatcher, job_id: str) -> AsyncIterator[JobSummary]:
    """The job as it is now and after each change, up to its end or the server's; changes that come fast are joined."""
    last: JobSummary | None = None
    with changes.subscribe(job_id) as changed:
        while not changes.closed:
            now = await to_thread.run_sync(look, engine, dispatcher, job_id)
            if now != last:
                yield now
                last = now
            if now.state.final:
                return
            await wait(changed, LOOK_EVERY)
