"""Rows of the table of webhooks: an outbox. Who makes an attempt takes it first, and writes under its number."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, RowMapping, exists, insert, literal, select, update

from woodcock_server.tables import webhooks
from woodcock_server.webhooks.schemas import DeliveryState

#: Nothing was sent yet.
UNSENT = {"state": DeliveryState.WAITING, "attempts": 0}


def add(connection: Connection, asked: Mapping[str, Mapping[str, str]]) -> None:
    """asked: by job, url and secret."""
    if rows := [{"job_id": job_id, **webhook, **UNSENT} for job_id, webhook in asked.items()]:
        connection.execute(insert(webhooks), rows)


def carry_over(connection: Connection, old: str, new: str) -> None:
    """Who was to be told of one job's end is told of another's, too."""
    told = select(literal(new), webhooks.c.url, webhooks.c.secret, *map(literal, UNSENT.values()))
    columns = ["job_id", "url", "secret", *UNSENT]
    connection.execute(insert(webhooks).from_select(columns, told.where(webhooks.c.job_id == old)))


def jobs_ended(connection: Connection, job_ids: Collection[str], now: datetime) -> None:
    """In the transaction of the end itself: whoever asked for it will be told, whatever happens."""
    connection.execute(update(webhooks).where(webhooks.c.job_id.in_(job_ids)).values(due_at=now))


def of_jobs(connection: Connection, job_ids: Collection[str]) -> dict[str, dict[str, Any]]:
    """By job, what the API shows of its webhook: never the secret."""
    columns = (webhooks.c.job_id, webhooks.c.url, webhooks.c.state, webhooks.c.attempts, webhooks.c.error)
    found = connection.execute(select(*columns).where(webhooks.c.job_id.in_(job_ids))).mappings()
    return {row["job_id"]: dict(row) for row in found}


# For deliveries


def any_due(connection: Connection, now: datetime) -> bool:
    return bool(connection.scalar(select(exists().where(webhooks.c.due_at <= now))))


def take(connection: Connection, now: datetime, until: datetime, most: int) -> Sequence[RowMapping]:
    """The attempts that are due, the oldest first, for the caller to make; others see them due again then."""
    due = webhooks.c.due_at <= now
    oldest = select(webhooks.c.job_id).where(due).order_by(webhooks.c.due_at).limit(most)
    # `due` again: PostgreSQL looks once more at a row that another server has taken meanwhile.
    taken = update(webhooks).where(webhooks.c.job_id.in_(oldest), due)
    values = {"attempts": webhooks.c.attempts + 1, "due_at": until}
    return connection.execute(taken.values(**values).returning(webhooks)).mappings().all()


def write_taken(connection: Connection, job_id: str, attempt: int, **values: Any) -> bool:
    """What came of an attempt; False if another was begun since."""
    own = webhooks.c.job_id == job_id, webhooks.c.attempts == attempt
    return connection.execute(update(webhooks).where(*own).values(**values)).rowcount == 1
