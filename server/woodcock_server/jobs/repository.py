"""Rows of the table of jobs. A dispatcher's writes name the token of its claim, so one that lost its lease writes
nothing."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any, TypeAlias

from sqlalchemy import (
    Column,
    ColumnElement,
    Connection,
    RowMapping,
    and_,
    bindparam,
    delete,
    exists,
    func,
    insert,
    literal,
    or_,
    select,
    update,
)

from woodcock.scene import UPLOADED
from woodcock_server.identifiers import new_id
from woodcock_server.jobs.states import FINAL, State
from woodcock_server.tables import (
    UtcDateTime,
    batches,
    comparisons,
    job_devices,
    job_events,
    job_files,
    job_tags,
    jobs,
)
from woodcock_server.webhooks import repository as webhooks

#: A job: its columns, its tags, the devices that rendered it and what may be seen of its webhook.
Row: TypeAlias = Mapping[str, Any]

#: What a job that is asked for is asked for with, where nothing is said.
PLAIN: Row = {
    "owner": "",
    "pinned": False,
    "priority": 0,
    **dict.fromkeys(("reference", "comparison", "batch", "point", "retry_of", "extends")),
}
#: Ids that one statement may name, by what databases take.
MOST_AT_ONCE = 500
#: Ids of uploaded files, in whatever names them.
UPLOADS = re.compile(rf"{UPLOADED}[0-9a-f]{{64}}")
#: How far a new job is.
NOTHING: Row = {"samples": 0, "seconds": 0.0, "series": [], "usage": {}, "spent": {}}


def add(connection: Connection, asked: Row, now: datetime, job_id: str | None = None) -> str:
    """A new job in the queue; returns its id. asked: name, scene and device, perhaps tags, a webhook and what PLAIN and
    NOTHING have. Raises sqlalchemy.exc.IntegrityError where a file that it names is no more."""
    job_id = job_id or new_id()
    add_all(connection, {job_id: asked}, now)
    return job_id


def add_all(connection: Connection, asked: Mapping[str, Row], now: datetime) -> None:
    """New jobs in the queue, by their ids; each as `add` takes it, all with the same keys. Raises as `add` does."""
    same = {"state": State.QUEUED, "created_at": now, "token": 0, **PLAIN, **NOTHING}
    rows = [
        {**same, **columns, "id": job_id, "paths": paths(columns["scene"]), "integrator": integrator(columns)}
        for job_id, columns in asked.items()
    ]
    tags = {row["id"]: row.pop("tags", ()) for row in rows}
    told = {row["id"]: row.pop("webhook", None) for row in rows}
    connection.execute(insert(jobs), rows)
    _record(connection, list(asked), State.QUEUED)
    _tag(connection, tags)
    _add_devices(connection, {row["id"]: row["usage"] for row in rows})
    named = {row["id"]: set(UPLOADS.findall(json.dumps([row["scene"], row["reference"]]))) for row in rows}
    if files := [{"job_id": job_id, "file": file} for job_id, each in named.items() for file in sorted(each)]:
        connection.execute(insert(job_files), files)
    webhooks.add(connection, {job_id: webhook for job_id, webhook in told.items() if webhook is not None})


def paths(scene: Row) -> int:
    """Samples × pixels that a scene (JSON) asks for; 0 where its contract is of something else."""
    samples = scene["stop"].get("samples", 0)
    return int(samples * scene["film"]["width"] * scene["film"]["height"])


def integrator(values: Row) -> str | None:
    """By which a device that prepared the job renders it; values: its usage may be among them."""
    return next((use["kinds"]["integrator"][0] for use in values.get("usage", {}).values()), None)


def get(connection: Connection, job_id: str) -> Row | None:
    found = connection.execute(select(jobs).where(jobs.c.id == job_id)).mappings().all()
    return next(iter(whole(connection, found)), None)


def change(connection: Connection, job_id: str, columns: Row) -> None:
    """Of a job, if it exists; columns: tags may be among them."""
    values = {"name": jobs.c.name, **columns}  # something is written in any case, and first
    tags = values.pop("tags", None)
    found = connection.execute(update(jobs).where(jobs.c.id == job_id).values(**values)).rowcount == 1
    if found and tags is not None:
        connection.execute(delete(job_tags).where(job_tags.c.job_id == job_id))
        _tag(connection, {job_id: tags})


def cancel(connection: Connection, job_id: str, now: datetime) -> bool:
    """A job that waits is cancelled, one that is rendered is to be; False for one that is either, or has ended."""
    return bool(_cancel(connection, jobs.c.id == job_id, now))


def cancel_batch(connection: Connection, batch_id: str, now: datetime) -> list[str]:
    """Each job of a batch that has not ended, as `cancel` does; returns which."""
    return _cancel(connection, jobs.c.batch == batch_id, now)


def _cancel(connection: Connection, meant: ColumnElement[bool], now: datetime) -> list[str]:
    # What is to be cancelled already is left to its holder.
    waits = and_(meant, jobs.c.state == State.QUEUED)
    waited = _move(connection, waits, State.CANCELLED, finished_at=now)
    return [*waited, *_move(connection, meant, State.CANCELLING)]


def remove(connection: Connection, job_id: str, unless_pinned: bool = False) -> bool:
    """Forget a job that has ended, and a batch with the last of its jobs; False for one that has not."""
    goes = [jobs.c.id == job_id, jobs.c.state.in_(FINAL), *([~jobs.c.pinned] if unless_pinned else [])]
    gone = connection.execute(delete(jobs).where(*goes).returning(jobs.c.batch)).first()
    if gone is not None and gone.batch is not None:
        remove_empty(connection, gone.batch)
    return gone is not None


def remove_empty(connection: Connection, batch_id: str) -> bool:
    """Forget a batch that has no jobs; False for one that has some."""
    empty = ~exists().where(jobs.c.batch == batch_id)
    return connection.execute(delete(batches).where(batches.c.id == batch_id, empty)).rowcount == 1


def unmeasured(connection: Connection, limit: int) -> list[str]:
    """Jobs that have ended, and of which nobody knows how much room they take; so many at most."""
    query = select(jobs.c.id).where(jobs.c.state.in_(FINAL), jobs.c.size.is_(None))
    return list(connection.execute(query.limit(limit)).scalars())


def measured(connection: Connection, sizes: Mapping[str, int]) -> None:
    """Jobs' files take so many bytes."""
    if rows := [{"job": job_id, "bytes": size} for job_id, size in sizes.items()]:
        connection.execute(update(jobs).where(jobs.c.id == bindparam("job")).values(size=bindparam("bytes")), rows)


def users(connection: Connection, job_id: str) -> list[str]:
    """Jobs that have not ended and are held against this one's picture."""
    query = select(jobs.c.id).where(jobs.c.reference == job_id, jobs.c.state.not_in(FINAL))
    return list(connection.execute(query).scalars())


def folders(connection: Connection) -> set[str]:
    """Ids of whatever may have a folder."""
    return {*connection.execute(select(jobs.c.id)).scalars(), *connection.execute(select(comparisons.c.id)).scalars()}


def waiting(connection: Connection) -> dict[str, int]:
    """How many jobs wait in the queue, by what device they ask for."""
    query = select(jobs.c.device, func.count()).where(jobs.c.state == State.QUEUED).group_by(jobs.c.device)
    return {asked: int(count) for asked, count in connection.execute(query)}


def events(connection: Connection, job_id: str, after: int) -> Sequence[RowMapping]:
    """States that the job came to after an event of that id, in order: id, state, at."""
    query = select(job_events).where(job_events.c.job_id == job_id, job_events.c.id > after)
    return connection.execute(query.order_by(job_events.c.id)).mappings().all()


#: What differs whenever a job's row was written by who renders it, or by who asked for it.
Mark: TypeAlias = tuple[Any, ...]


def marks(connection: Connection, job_ids: Collection[str]) -> dict[str, Mark]:
    """Of those of the jobs that there are."""
    columns = ("state", "token", "samples", "seconds", "rmse", "name", "priority", "pinned")
    found, ids = dict[str, Mark](), list(job_ids)
    for first in range(0, len(ids), MOST_AT_ONCE):
        some = jobs.c.id.in_(ids[first : first + MOST_AT_ONCE])
        for row in connection.execute(select(jobs.c.id, *(jobs.c[name] for name in columns)).where(some)):
            found[row.id] = tuple(row)[1:]
    return found


# For dispatchers

#: Over how long owners get equal shares of rendering time.
FAIR_OVER = timedelta(days=1)


def next_claimable(connection: Connection, now: datetime, devices: Collection[str]) -> str | None:
    """A job that waits, or whose holder let its lease run out, and that asks for one of these devices: of the highest
    priority; of these, of the owner who was rendered for least; of these, the oldest.

    devices: ids, and ANY if jobs may be claimed that ask for none.
    """
    asked = and_(_claimable(now), jobs.c.device.in_(devices))
    first = and_(asked, jobs.c.priority == select(func.max(jobs.c.priority)).where(asked).scalar_subquery())
    owners = list(connection.execute(select(jobs.c.owner).where(first).distinct()).scalars())
    if len(owners) > 1:  # Of one alone nobody need know, nor of those who wait for nothing.
        owners = _had_least(connection, owners, now - FAIR_OVER)
    oldest = select(func.min(jobs.c.id)).where(first, jobs.c.owner.in_(owners))
    return connection.execute(oldest).scalar() if owners else None


def _had_least(connection: Connection, owners: Collection[str], since: datetime) -> list[str]:
    """Of these owners, those for whom least was rendered."""
    mine = jobs.c.owner.in_(owners), jobs.c.started_at > since
    had = select(jobs.c.owner, func.sum(jobs.c.seconds)).where(*mine).group_by(jobs.c.owner)
    seconds = dict.fromkeys(owners, 0.0) | {row[0]: row[1] for row in connection.execute(had)}
    least = min(seconds.values())
    return [owner for owner in owners if seconds[owner] == least]


def claim(connection: Connection, job_id: str, holder: str, now: datetime, lease: timedelta) -> Row | None:
    """Take the job under a new token; None if another was faster."""
    started = func.coalesce(jobs.c.started_at, literal(now, UtcDateTime))
    values = {"token": jobs.c.token + 1, "holder": holder, "lease_until": now + lease, "started_at": started}
    taken = _move(connection, and_(jobs.c.id == job_id, _claimable(now)), State.RUNNING, **values)
    return get(connection, job_id) if taken else None


def write_held(connection: Connection, job_id: str, token: int, values: dict[str, Any]) -> bool:
    """Write to a job's row as the holder of the token; False if it is held under another, or by nobody, or is to be
    cancelled. values: the state may be among them."""
    held = and_(jobs.c.id == job_id, jobs.c.token == token, jobs.c.state == State.RUNNING)
    assert State.RUNNING in State(values.get("state", State.RUNNING)).before
    if "usage" in values:
        values = {**values, "integrator": integrator(values)}
    written = connection.execute(update(jobs).where(held).values(**values)).rowcount == 1
    if written and "usage" in values:
        known = select(job_devices.c.device).where(job_devices.c.job_id == job_id)
        _add_devices(connection, {job_id: {*values["usage"]} - {*connection.execute(known).scalars()}})
    if written and "state" in values:
        _record(connection, [job_id], State(values["state"]))
    return written


def let_go(connection: Connection, job_id: str, token: int, now: datetime) -> bool:
    """The holder of the token stops rendering a job that is to be cancelled; False if it is not."""
    held = and_(jobs.c.id == job_id, jobs.c.token == token, jobs.c.state == State.CANCELLING)
    return bool(_move(connection, held, State.CANCELLED, finished_at=now, **NOBODY))


def abandoned(connection: Connection, now: datetime) -> list[tuple[str, int]]:
    """Jobs that are to be cancelled and whose holder let the lease run out: ids and tokens."""
    query = select(jobs.c.id, jobs.c.token).where(jobs.c.state == State.CANCELLING, jobs.c.lease_until < now)
    return [(row.id, row.token) for row in connection.execute(query)]


#: Of a job that no dispatcher holds.
NOBODY: dict[str, Any] = {"holder": None, "lease_until": None}


def _move(connection: Connection, meant: ColumnElement[bool], state: State, **values: Any) -> list[str]:
    """Of the jobs that are meant, those to another state that it may follow; returns which were."""
    found = update(jobs).where(meant, jobs.c.state.in_(state.before)).values(state=state, **values)
    moved = list(connection.execute(found.returning(jobs.c.id)).scalars())
    if moved:
        _record(connection, moved, state)
    return moved


def _record(connection: Connection, job_ids: Sequence[str], state: State) -> None:
    """The jobs have come to a state, in the same transaction."""
    now = datetime.now(UTC)
    connection.execute(insert(job_events), [{"job_id": job_id, "state": state, "at": now} for job_id in job_ids])
    if state.final:
        webhooks.jobs_ended(connection, job_ids, now)


def _claimable(now: datetime) -> ColumnElement[bool]:
    return or_(
        jobs.c.state == State.QUEUED,
        and_(jobs.c.state == State.RUNNING, jobs.c.lease_until < now),
    )


def _tag(connection: Connection, tags: Mapping[str, Iterable[str]]) -> None:
    if rows := [{"job_id": job_id, "tag": tag} for job_id, each in tags.items() for tag in each]:
        connection.execute(insert(job_tags), rows)


def _add_devices(connection: Connection, devices: Mapping[str, Iterable[str]]) -> None:
    if rows := [{"job_id": job_id, "device": device} for job_id, each in devices.items() for device in each]:
        connection.execute(insert(job_devices), rows)


def whole(connection: Connection, rows: Sequence[Mapping[Any, Any]]) -> list[Row]:
    """Jobs, from their columns."""
    ids = [row["id"] for row in rows]
    tags, devices = _words(connection, job_tags.c.tag, ids), _words(connection, job_devices.c.device, ids)
    told = webhooks.of_jobs(connection, ids)
    return [
        {**row, "tags": tags[row["id"]], "devices": devices[row["id"]], "webhook": told.get(row["id"])} for row in rows
    ]


def _words(connection: Connection, word: Column[str], ids: Sequence[str]) -> Mapping[str, list[str]]:
    """What a table of words has of each job, sorted."""
    found = defaultdict[str, list[str]](list)
    job_id = word.table.c.job_id
    for row in connection.execute(select(job_id, word).where(job_id.in_(ids)).order_by(word)):
        found[row[0]].append(row[1])
    return found
