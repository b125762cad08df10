"""Submitting jobs and following them."""

from __future__ import annotations

from collections.abc import AsyncIterator
from datetime import UTC, datetime

from anyio import to_thread
from sqlalchemy import Engine, RowMapping

from woodcock.denoise import DenoiseError, require
from woodcock.scene import Scene
from woodcock_server.events import Changes, wait
from woodcock_server.jobs import repository
from woodcock_server.jobs.schemas import JobCreate, JobSummary, summary
from woodcock_server.problems import Fault, InvalidRequest
from woodcock_server.volumes.check import check_scene

#: A job that another server renders announces nothing here: its row is looked at this often, seconds.
LOOK_EVERY = 2.0


def create(engine: Engine, request: JobCreate) -> RowMapping:
    """Commit a new job to the queue. Raises InvalidRequest."""
    check_scene(engine, request.scene)
    _check_denoiser(request.scene)
    with engine.begin() as connection:
        job_id = repository.add(connection, request.name, request.scene.model_dump(mode="json"), datetime.now(UTC))
    row = find(engine, job_id)
    assert row is not None, "jobs are never deleted"
    return row


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


async def follow(engine: Engine, changes: Changes, job_id: str) -> AsyncIterator[JobSummary]:
    """The job as it is now and after each change, up to its end or the server's; changes that come fast are joined."""
    last: JobSummary | None = None
    with changes.subscribe(job_id) as changed:
        while not changes.closed:
            row = await to_thread.run_sync(find, engine, job_id)
            assert row is not None, "jobs are never deleted"
            now = summary(row)
            if now != last:
                yield now
                last = now
            if now.state.final:
                return
            await wait(changed, LOOK_EVERY)
