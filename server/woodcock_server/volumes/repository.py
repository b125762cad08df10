"""Rows of the table of volumes."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, RowMapping, insert, select

from woodcock_server.identifiers import new_id
from woodcock_server.paging import fetch_page
from woodcock_server.tables import volumes


def get(connection: Connection, volume_id: str) -> RowMapping | None:
    return connection.execute(select(volumes).where(volumes.c.id == volume_id)).mappings().one_or_none()


def add(connection: Connection, volume_id: str, name: str, size: int, contents: dict[str, Any]) -> None:
    """contents: of `contents.read`. Raises sqlalchemy.exc.IntegrityError if it is there."""
    row = {"id": volume_id, "name": name, "size": size, **contents}
    connection.execute(insert(volumes).values(entry=new_id(), created_at=datetime.now(UTC), **row))


def page(connection: Connection, limit: int, cursor: str | None) -> tuple[Sequence[RowMapping], str | None]:
    return fetch_page(connection, select(volumes), volumes.c.entry, limit, cursor)
