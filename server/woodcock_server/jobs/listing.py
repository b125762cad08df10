"""Which jobs are meant: pages of them, and how many there are of each sort."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import Column, ColumnElement, Connection, func, select

from woodcock_server.jobs.repository import Row, whole
from woodcock_server.jobs.states import State
from woodcock_server.paging import fetch_page
from woodcock_server.tables import job_devices, job_tags, jobs

#: Of tags, devices and integrators, how many are counted.
MOST_COUNTED = 200


@dataclass(frozen=True)
class Filter:
    """Which jobs are meant, where something is said: states, any of these; tags, all of these; owner; text: a part of
    the name, in letters of any case; since, before: of their creation; batch: that they are of; device: that rendered
    them; integrator: that they are rendered by."""

    states: Collection[State] = ()
    tags: Collection[str] = ()
    owner: str | None = None
    text: str | None = None
    since: datetime | None = None
    before: datetime | None = None
    batch: str | None = None
    device: str | None = None
    integrator: str | None = None

    @property
    def conditions(self) -> Iterator[ColumnElement[bool]]:
        if self.states:
            yield jobs.c.state.in_(self.states)
        for tag in self.tags:
            yield jobs.c.id.in_(select(job_tags.c.job_id).where(job_tags.c.tag == tag))
        if self.owner is not None:
            yield jobs.c.owner == self.owner
        if self.text is not None:
            yield jobs.c.name.icontains(self.text, autoescape=True)
        if self.since is not None:
            yield jobs.c.created_at >= self.since
        if self.before is not None:
            yield jobs.c.created_at < self.before
        if self.batch is not None:
            yield jobs.c.batch == self.batch
        if self.device is not None:
            yield jobs.c.id.in_(select(job_devices.c.job_id).where(job_devices.c.device == self.device))
        if self.integrator is not None:
            yield jobs.c.integrator == self.integrator


#: Columns that grow with a render, and of which a listing tells nothing.
LONG = ("series", "usage", "spent", "kept")


def page(connection: Connection, limit: int, cursor: str | None, meant: Filter) -> tuple[Sequence[Row], str | None]:
    query = select(*(column for column in jobs.c if column.name not in LONG)).where(*meant.conditions)
    rows, following = fetch_page(connection, query, jobs.c.id, limit, cursor)
    return whole(connection, rows), following


def states(connection: Connection) -> dict[State, int]:
    """How many jobs are in each state."""
    query = select(jobs.c.state, func.count()).group_by(jobs.c.state)
    return dict.fromkeys(State, 0) | {State(state): count for state, count in connection.execute(query)}


def counted(connection: Connection, word: Column[str]) -> dict[str, int]:
    """Of the values that a column has, how many rows have each; those that most have, sorted."""
    number = func.count()
    query = select(word, number).where(word.is_not(None)).group_by(word).order_by(number.desc(), word)
    return dict(sorted((value, count) for value, count in connection.execute(query.limit(MOST_COUNTED))))
