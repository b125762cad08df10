"""Pages of a listing: newest first, a cursor that stays right while rows come in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any
from urllib.parse import urlencode

from fastapi import Query, Request, Response
from sqlalchemy import Column, Connection, RowMapping, Select

from woodcock_server.identifiers import PATTERN

Limit = Annotated[int, Query(ge=1, le=200, description="How many at most.")]
Cursor = Annotated[str | None, Query(pattern=PATTERN, description="`next` of the page before.")]


def fetch_page(
    connection: Connection, query: Select[*tuple[Any, ...]], order: Column[str], limit: int, cursor: str | None
) -> tuple[Sequence[RowMapping], str | None]:
    """Up to `limit` rows below the cursor, greatest first, and the cursor of the next page if there is one."""
    if cursor is not None:
        query = query.where(order < cursor)
    rows = connection.execute(query.order_by(order.desc()).limit(limit + 1)).mappings().all()
    return rows[:limit], rows[limit - 1][order] if len(rows) > limit else None


def link_next(request: Request, response: Response, cursor: str | None) -> None:
    """RFC 8288: the next page in the Link header, with the query of this one."""
    if cursor is not None:
        kept = [(name, value) for name, value in request.query_params.multi_items() if name != "cursor"]
        query = urlencode([*kept, ("cursor", cursor)])
        response.headers["Link"] = f'<{request.url.path}?{query}>; rel="next"'
