"""Submitting jobs and following them."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from typing import Any, NamedTuple

from anyio import to_thread
from fastapi import HTTPException
from pydantic import BaseModel
from sqlalchemy import Connection, Engine
from sqlalchemy.exc import IntegrityError

from woodcock.scene import RelativeErrorStop, SamplesStop, Scene, SecondsStop, Stop
from woodcock_server import idempotency
from woodcock_server.dispatcher import Dispatcher
from woodcock_server.events import Changes, wait
from woodcock_server.identifiers import new_id
from woodcock_server.jobs import repository
from woodcock_server.jobs.requests import RequestCheck
from woodcock_server.jobs.schemas import (
    Job,
    JobChange,
    JobCreate,
    JobEvent,
    JobExtension,
    JobsDeleted,
    JobSummary,
    job,
    summary,
)
from woodcock_server.jobs.states import State
from woodcock_server.problems import Conflict, Fault, InvalidRequest
from woodcock_server.services import Services
from woodcock_server.webhooks import repository as webhooks

#: Changes of a row are told. That its device is being checked, say, is none: so the job is looked at besides, seconds.
LOOK_EVERY = 30.0


def create(services: Services, request: JobCreate, owner: str, key: str | None = None) -> Job:
    """Commit a new job to the queue. key: under which the request may come twice. Raises InvalidRequest, TooMuch."""
    return idempotency.once(services.engine, key, owner, request, Job, partial(_create, services, request, owner, key))


def _create(services: Services, request: JobCreate, owner: str, key: str | None) -> Job:
    RequestCheck(services).check(request)
    now, asked = datetime.now(UTC), {**request.model_dump(mode="json"), "owner": owner}
    admit(services, owner, [asked["scene"]])
    with services.engine.begin() as connection:
        job_id = repository.add(connection, asked, now)
        made = described(connection, services.dispatcher, existing(connection, job_id))
        idempotency.keep(connection, key, owner, request, made, now)
    return made


def admit(services: Services, owner: str, scenes: Sequence[Mapping[str, Any]]) -> None:
    """Raises TooMuch, and InvalidRequest, for more than the owner may have."""
    with services.engine.connect() as connection:
        services.limits.check(connection, owner, scenes)


def described(connection: Connection, dispatcher: Dispatcher, row: repository.Row) -> Job:
    return job(row, *waiting(connection, dispatcher, [row]))


# The life of a job


def change(services: Services, job_id: str, asked: JobChange) -> Job:
    """The job afterwards. Raises JobMissing."""
    with services.engine.begin() as connection:
        repository.change(connection, job_id, asked.columns)
        return described(connection, services.dispatcher, existing(connection, job_id))


def cancel(services: Services, job_id: str) -> Job:
    """The job afterwards: cancelled, or to be so as soon as its holder lets go of it. Raises JobMissing, Conflict."""
    with services.engine.begin() as connection:
        done = repository.cancel(connection, job_id, datetime.now(UTC))
        row = existing(connection, job_id)
        if not done and State(row["state"]).final:
            raise Conflict(f"Job {job_id} has ended: it is {row['state']}. Only what has not can be cancelled.")
        return described(connection, services.dispatcher, row)


def retry(services: Services, job_id: str, owner: str, key: str | None = None) -> Job:
    """A new job that asks for the same. Raises JobMissing, Conflict, InvalidRequest, TooMuch."""
    asked = Retry(retry_of=job_id)
    return idempotency.once(services.engine, key, owner, asked, Job, partial(_retry, services, asked, owner, key))


def _retry(services: Services, again: Retry, owner: str, key: str | None) -> Job:
    row = _row(services, again.retry_of)
    if row["state"] not in (State.FAILED, State.CANCELLED):
        raise Conflict(f"Job {row['id']} is {row['state']}. Only one that failed or was cancelled can be tried again.")
    request = JobCreate.model_validate(_asked(row))
    RequestCheck(services).check(request)
    place = {key: row[key] for key in ("batch", "point")}
    asked = {**request.model_dump(mode="json"), **place, "retry_of": row["id"], "owner": owner}
    admit(services, owner, [asked["scene"]])
    return _follow_up(services, row, asked, new_id(), again, key)


def extend(services: Services, job_id: str, asked: JobExtension, owner: str, key: str | None = None) -> Job:
    """A new job that goes on from the samples of one that has succeeded. Raises as `retry` does."""
    longer = Extension(extends=job_id, stop=asked.stop)
    return idempotency.once(services.engine, key, owner, longer, Job, partial(_extend, services, longer, owner, key))


def _extend(services: Services, longer: Extension, owner: str, key: str | None) -> Job:
    old, stop = longer.extends, longer.stop
    row = _row(services, old)
    if row["state"] != State.SUCCEEDED:
        raise Conflict(f"Job {old} is {row['state']}. Only one that has succeeded can be gone on from.")
    before = Scene.model_validate(row["scene"])
    _check_stricter(before.stop, stop)
    request = JobCreate.model_validate(_asked(row) | {"scene": before.model_copy(update={"stop": stop})})
    RequestCheck(services).check(request)
    same = {key: row[key] for key in (*repository.NOTHING, "rmse", "relative_rmse")}
    if not any(path.partition(".")[0] == "stop" for path in row["point"] or ()):  # It is where the old one is.
        same |= {key: row[key] for key in ("batch", "point")}
    columns = {**request.model_dump(mode="json"), **same, "extends": old, "owner": owner}
    admit(services, owner, [columns["scene"]])
    job_id = new_id()
    if not services.storage.hand_on(old, job_id):
        raise Conflict(f"Job {old} has no samples to go on from: it ended under a version that kept none.")
    return _follow_up(services, row, columns, job_id, longer, key)


class Retry(BaseModel):
    """What is asked for by trying a job again; an Idempotency-Key belongs to that."""

    retry_of: str


class Extension(JobExtension):
    """The same of extending one."""

    extends: str


def _follow_up(
    services: Services, row: repository.Row, asked: repository.Row, job_id: str, request: BaseModel, key: str | None
) -> Job:
    """A new job that follows from another one. Raises sqlalchemy.exc.IntegrityError if that was deleted in the
    meantime, and with it its batch or a file, or if the same request was faster."""
    now = datetime.now(UTC)
    try:
        with services.engine.begin() as connection:
            repository.add(connection, asked, now, job_id)
            webhooks.carry_over(connection, row["id"], job_id)
            made = described(connection, services.dispatcher, existing(connection, job_id))
            idempotency.keep(connection, key, asked["owner"], request, made, now)
    except IntegrityError:
        services.storage.remove_job(job_id)
        raise
    return made


def _row(services: Services, job_id: str) -> repository.Row:
    """Raises JobMissing."""
    with services.engine.connect() as connection:
        return existing(connection, job_id)


def _asked(row: repository.Row) -> dict[str, Any]:
    """What a job was asked for with, but the webhook: its secret does not leave the database for that."""
    return {key: row[key] for key in JobCreate.model_fields if key != "webhook"}


def _check_stricter(before: Stop, after: Stop) -> None:
    """Raises InvalidRequest."""
    match before, after:
        case SamplesStop(samples=old), SamplesStop(samples=new):
            field, stricter, says = "samples", new > old, f"more than {old}"
        case SecondsStop(seconds=old), SecondsStop(seconds=new):
            field, stricter, says = "seconds", new > old, f"more than {old:g}"
        case RelativeErrorStop(relative_error=old), RelativeErrorStop(relative_error=new):
            field, stricter, says = "relative_error", new < old, f"less than {old:g}"
            if after.per != before.per:
                field, stricter, says = "per", False, f"`{before.per}`, as it was"
        case _:
            field, stricter, says = "kind", False, f"`{before.kind}`, as it was"
    if not stricter:
        fault = Fault(field=f"stop.{field}", message=f"must be {says}")
        raise InvalidRequest("The picture is as good already, or the contract is of another kind.", fault)


def delete(services: Services, row: repository.Row) -> None:
    """Forget a job and its files. Raises Conflict."""
    job_id = row["id"]
    if row["comparison"]:
        raise Conflict(f"Job {job_id} is a variant of the comparison {row['comparison']}, which needs it.")
    with services.engine.connect() as connection:
        users = repository.users(connection, job_id)
    if users:
        raise Conflict(f"Job {job_id} is what {', '.join(users)} is held against; that has not ended yet.")
    with services.engine.begin() as connection:
        removed = repository.remove(connection, job_id)
    if not removed:
        raise Conflict(f"Job {job_id} is {row['state']}. Cancel it first.")
    services.storage.remove_job(job_id)


def delete_all(services: Services, job_ids: Sequence[str]) -> JobsDeleted:
    """Forget those of the jobs that can be deleted, and their files."""
    kept = dict[str, str]()
    for job_id in job_ids:
        try:
            with services.engine.connect() as connection:
                row = existing(connection, job_id)
            delete(services, row)
        except Conflict as conflict:
            kept[job_id] = str(conflict)
        except JobMissing:
            pass
    return JobsDeleted(deleted=[job_id for job_id in job_ids if job_id not in kept], kept=kept)


class JobMissing(HTTPException):
    """A 404."""

    def __init__(self, job_id: str) -> None:
        super().__init__(404, f"There is no job {job_id}.")


def existing(connection: Connection, job_id: str) -> repository.Row:
    """Raises JobMissing."""
    row = repository.get(connection, job_id)
    if row is None:
        raise JobMissing(job_id)
    return row


def waiting(connection: Connection, dispatcher: Dispatcher, rows: Sequence[repository.Row]) -> list[str | None]:
    """Of each job why it would not be rendered even if no job were before it; None also for those that do not wait."""
    asked = {row["device"] for row in rows if row["state"] == State.QUEUED}
    reasons = {device: dispatcher.hindrance(connection, device) for device in asked}
    return [reasons[row["device"]] if row["state"] == State.QUEUED else None for row in rows]


class Look(NamedTuple):
    """job: as it is now, None if it is no more; events: what came to be since an event, by id."""

    job: JobSummary | None
    events: dict[int, JobEvent]


def look(engine: Engine, dispatcher: Dispatcher, job_id: str, after: int) -> Look:
    with engine.connect() as connection:
        row = repository.get(connection, job_id)
        if row is None:
            return Look(None, {})
        found = repository.events(connection, job_id, after)
        events = {event["id"]: JobEvent(state=event["state"], at=event["at"]) for event in found}
        return Look(summary(row, *waiting(connection, dispatcher, [row])), events)


async def follow(
    engine: Engine, changes: Changes, dispatcher: Dispatcher, job_id: str, after: int = 0
) -> AsyncIterator[tuple[int, JobEvent] | JobSummary]:
    """The states that the job came to after an event of that id, each with its own; then the job as it is now. Again
    after each change, up to its end or the server's; changes that come fast are joined, states are not."""
    last: JobSummary | None = None
    with changes.subscribe(job_id) as changed:
        while not changes.closed:
            now, events = await to_thread.run_sync(look, engine, dispatcher, job_id, after)
            if now is None:
                return
            for after, event in events.items():
                yield after, event
            if now != last:
                yield now
                last = now
            if now.state.final:
                return
            await wait(changed, LOOK_EVERY)
