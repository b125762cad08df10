"""Rows of the table of batches, and what concerns all jobs of one."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from datetime import datetime

from sqlalchemy import Connection, delete, exists, func, insert, select

from woodcock_server.identifiers import new_id
from woodcock_server.jobs.repository import Row, add_all, remove_empty
from woodcock_server.jobs.states import UNENDED, State
from woodcock_server.paging import fetch_page
from woodcock_server.tables import batches, jobs


def add(connection: Connection, asked: Row, made: Sequence[Row], now: datetime) -> str:
    """A new batch; returns its id. asked: owner, name, scene, product and zip; made: its jobs, in order."""
    batch_id = new_id()
    connection.execute(insert(batches).values(id=batch_id, created_at=now, **asked))
    add_all(connection, {new_id(): {**job, "batch": batch_id} for job in made}, now)
    return batch_id


def get(connection: Connection, batch_id: str) -> Row | None:
    found = connection.execute(select(batches).where(batches.c.id == batch_id)).mappings().one_or_none()
    return None if found is None else {**found}


def page(connection: Connection, limit: int, cursor: str | None) -> tuple[list[Row], str | None]:
    rows, following = fetch_page(connection, select(batches), batches.c.id, limit, cursor)
    return [{**row} for row in rows], following


#: Of a job, what its batch says of it: not the series, which are long.
COLUMNS = [
    jobs.c[name]
    for name in (
        *("id", "point", "state", "device", "scene", "samples", "seconds", "reached", "relative_rmse"),
        "integrator",
        *("retry_of", "extends", "error"),
    )
]


def jobs_of(connection: Connection, batch_id: str) -> list[Row]:
    """In the order in which they were made, without their tags."""
    query = select(*COLUMNS).where(jobs.c.batch == batch_id).order_by(jobs.c.id)
    return [{**row} for row in connection.execute(query).mappings()]


def counts(connection: Connection, batch_ids: Collection[str]) -> Mapping[str, Mapping[State, int]]:
    """How many jobs of each batch are in each state."""
    query = select(jobs.c.batch, jobs.c.state, func.count()).where(jobs.c.batch.in_(batch_ids))
    found = defaultdict[str, dict[State, int]](lambda: dict.fromkeys(State, 0))
    for batch, state, count in connection.execute(query.group_by(jobs.c.batch, jobs.c.state)):
        found[batch][State(state)] = count
    return found


def users(connection: Connection, batch_id: str) -> list[str]:
    """Jobs that have not ended and are held against the picture of one of its jobs."""
    held = select(jobs.c.id).where(jobs.c.batch == batch_id)
    query = select(jobs.c.id).where(jobs.c.reference.in_(held), jobs.c.state.in_(UNENDED))
    return list(connection.execute(query).scalars())


def remove(connection: Connection, batch_id: str) -> list[str] | None:
    """Forget a batch and its jobs; returns which they were, None if one has not ended."""
    other = jobs.alias()
    unfinished = exists().where(other.c.batch == batch_id, other.c.state.in_(UNENDED))
    gone = delete(jobs).where(jobs.c.batch == batch_id, ~unfinished).returning(jobs.c.id)
    removed = list(connection.execute(gone).scalars())
    return removed if remove_empty(connection, batch_id) else None
