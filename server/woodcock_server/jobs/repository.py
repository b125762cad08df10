"""Rows of the table of jobs. A dispatcher's writes name the token of its claim, so one that lost its lease writes
nothing."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from datetime import datetime, timedelta
from typing import Any

from sqlalchemy import ColumnElement, Connection, RowMapping, and_, func, insert, literal, or_, select, update

from woodcock_server.identifiers import new_id
from woodcock_server.jobs.schemas import State
from woodcock_server.paging import fetch_page
from woodcock_server.tables import UtcDateTime, jobs


def add(
    connection: Connection,
    name: str,
    scene: dict[str, Any],
    device: str,
    now: datetime,
    reference: str | None = None,
    comparison: str | None = None,
) -> str:
    """A new job in the queue; returns its id."""
    job_id = new_id()
    asked = {"name": name, "scene": scene, "device": device, "reference": reference, "comparison": comparison}
    nothing = {"samples": 0, "seconds": 0.0, "series": [], "usage": {}, "spent": {}, "token": 0}
    connection.execute(insert(jobs).values(id=job_id, state=State.QUEUED, created_at=now, **asked, **nothing))
    return job_id


def get(connection: Connection, job_id: str) -> RowMapping | None:
    return connection.execute(select(jobs).where(jobs.c.id == job_id)).mappings().one_or_none()


def page(
    connection: Connection, limit: int, cursor: str | None, state: State | None
) -> tuple[Sequence[RowMapping], str | None]:
    query = select(jobs)
    if state is not None:
        query = query.where(jobs.c.state == state)
    return fetch_page(connection, query, jobs.c.id, limit, cursor)


def counts(connection: Connection) -> dict[State, int]:
    """How many jobs are in each state."""
    query = select(jobs.c.state, func.count()).group_by(jobs.c.state)
    return dict.fromkeys(State, 0) | {State(state): count for state, count in connection.execute(query)}


# For dispatchers


def next_claimable(connection: Connection, now: datetime, devices: Collection[str]) -> str | None:
    """The oldest job that waits, or whose holder let its lease run out, of those that ask for one of these devices.

    devices: ids, and ANY if jobs may be claimed that ask for none.
    """
    claimable = select(jobs.c.id).where(_claimable(now), jobs.c.device.in_(devices))
    return connection.execute(claimable.order_by(jobs.c.id).limit(1)).scalar()


def claim(connection: Connection, job_id: str, owner: str, now: datetime, lease: timedelta) -> RowMapping | None:
    """Take the job under a new token; None if another was faster."""
    taken = connection.execute(
        update(jobs)
        .where(jobs.c.id == job_id, _claimable(now))
        .values(
            state=State.RUNNING,
            token=jobs.c.token + 1,
            owner=owner,
            lease_until=now + lease,
            started_at=func.coalesce(jobs.c.started_at, literal(now, UtcDateTime)),
        )
    )
    return get(connection, job_id) if taken.rowcount == 1 else None


def write_held(connection: Connection, job_id: str, token: int, values: dict[str, Any]) -> bool:
    """Write to a job's row as the holder of the token; False if it is held under another, or by nobody."""
    held = and_(jobs.c.id == job_id, jobs.c.token == token, jobs.c.state == State.RUNNING)
    return connection.execute(update(jobs).where(held).values(**values)).rowcount == 1


def _claimable(now: datetime) -> ColumnElement[bool]:
    return or_(
        jobs.c.state == State.QUEUED,
        and_(jobs.c.state == State.RUNNING, jobs.c.lease_until < now),
    )
