"""Rows of the table of volumes."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, RowMapping, delete, exists, insert, select, update

from woodcock_server.identifiers import new_id
from woodcock_server.paging import fetch_page
from woodcock_server.tables import job_files, volumes


def get(connection: Connection, volume_id: str) -> RowMapping | None:
    return connection.execute(select(volumes).where(volumes.c.id == volume_id)).mappings().one_or_none()


def add(connection: Connection, volume_id: str, columns: dict[str, Any]) -> None:
    """columns: owner, name, size and those of schemas.Contents. Raises sqlalchemy.exc.IntegrityError if it is there."""
    now = datetime.now(UTC)
    connection.execute(insert(volumes).values(id=volume_id, entry=new_id(), created_at=now, used_at=now, **columns))


def use(connection: Connection, volume_id: str) -> bool:
    """Somebody needs it; False if it is not there."""
    used = update(volumes).where(volumes.c.id == volume_id).values(used_at=datetime.now(UTC))
    return connection.execute(used).rowcount == 1


def remove(connection: Connection, volume_id: str, before: datetime) -> bool:
    """Forget a file that no job names and nobody used since; False for others."""
    named = exists().where(job_files.c.file == volumes.c.id)
    goes = delete(volumes).where(volumes.c.id == volume_id, volumes.c.used_at < before, ~named)
    return connection.execute(goes).rowcount == 1


def page(connection: Connection, limit: int, cursor: str | None) -> tuple[Sequence[RowMapping], str | None]:
    return fetch_page(connection, select(volumes), volumes.c.entry, limit, cursor)
