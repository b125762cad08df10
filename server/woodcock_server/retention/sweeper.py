"""Deletes what is due, now and then, and finds out how much room the renders take that have ended."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime

import structlog
from sqlalchemy import Engine
from sqlalchemy.exc import SQLAlchemyError

from woodcock_server.comparisons import repository as comparisons
from woodcock_server.jobs import repository as jobs
from woodcock_server.retention.due import GRACE, Due, File, Group, Rule, due
from woodcock_server.storage import Storage, StoreAway
from woodcock_server.threads import in_thread
from woodcock_server.volumes import repository as volumes

log = structlog.get_logger()

#: Between two looks, seconds.
EVERY = 60.0
#: Renders that are measured by one look.
AT_ONCE = 10_000


@asynccontextmanager
async def running(engine: Engine, storage: Storage, rule: Rule) -> AsyncIterator[None]:
    """Sweep in the background."""
    task = asyncio.create_task(_run(engine, storage, rule), name="sweeper")
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def _run(engine: Engine, storage: Storage, rule: Rule) -> None:
    while True:
        try:
            await in_thread(sweep, engine, storage, rule, datetime.now(UTC))
        except (SQLAlchemyError, OSError, StoreAway) as error:
            log.error("nothing could be swept", reason=str(error))
        except Exception:  # One row's trouble must not be the end of all sweeping.
            log.exception("the sweeper stumbled")
        await asyncio.sleep(EVERY)


def sweep(engine: Engine, storage: Storage, rule: Rule, now: datetime) -> Due:
    """Measure what has ended, and delete what is due; blocks. Returns what was."""
    measure(engine, storage)
    with engine.connect() as connection:
        found = due(connection, rule, now)
    for group in found.groups:
        _remove(engine, storage, group)
    for file in found.files:
        _collect(engine, storage, file, now)
    storage.collect()
    return found


def measure(engine: Engine, storage: Storage) -> None:
    """Note the size of jobs that have ended lately."""
    with engine.connect() as connection:
        ended = jobs.unmeasured(connection, AT_ONCE)
    sizes = {job_id: storage.size(job_id) for job_id in ended}
    with engine.begin() as connection:
        jobs.measured(connection, sizes)


def _remove(engine: Engine, storage: Storage, group: Group) -> None:
    with engine.begin() as connection:
        removed = [job_id for job_id in group.jobs if jobs.remove(connection, job_id, unless_pinned=True)]
        if group.comparison and len(removed) == len(group.jobs):
            comparisons.remove(connection, group.comparison)
            removed.append(group.comparison)
    for folder in removed:
        storage.remove_job(folder)
    log.info("deleted by retention", job=group.jobs[0], name=group.name, jobs=len(group.jobs), size=group.size)


def _collect(engine: Engine, storage: Storage, file: File, now: datetime) -> None:
    # The file goes while its row is still locked: whoever uploads it again meanwhile waits, and brings it anew.
    with engine.begin() as connection:
        collected = volumes.remove(connection, file.id, now - GRACE)
        if collected:
            storage.drop_volume(file.id)
    if collected:
        log.info("unused file deleted", file=file.id, name=file.name, size=file.size)
