"""Jobs that another server renders, or changes: nobody announces that here, so that their rows are looked at."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Collection
from contextlib import asynccontextmanager

import structlog
from sqlalchemy import Engine
from sqlalchemy.exc import SQLAlchemyError

from woodcock_server.events import Changes
from woodcock_server.jobs import repository
from woodcock_server.threads import in_thread

log = structlog.get_logger()

#: Seconds; by one query for all whom somebody follows.
LOOK_EVERY = 2.0


@asynccontextmanager
async def running(engine: Engine, changes: Changes) -> AsyncIterator[None]:
    """Publish the changes of jobs that are followed."""
    task = asyncio.create_task(_run(engine, changes), name="watching")
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def _run(engine: Engine, changes: Changes) -> None:
    known: dict[str, repository.Mark] = {}
    while True:
        await asyncio.sleep(LOOK_EVERY)
        followed = changes.followed
        try:
            marks = await in_thread(_marks, engine, followed) if followed else {}
        except SQLAlchemyError as error:
            log.error("the database does not answer", error=str(error))
            continue
        for job_id in followed:
            # Also of one that is new here: it may have changed since its follower looked.
            if job_id not in known or marks.get(job_id) != known[job_id]:
                changes.publish(job_id)
        known = marks


def _marks(engine: Engine, job_ids: Collection[str]) -> dict[str, repository.Mark]:
    with engine.connect() as connection:
        return repository.marks(connection, job_ids)
