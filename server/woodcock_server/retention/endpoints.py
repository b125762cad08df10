"""/api/v1/retention"""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated

from fastapi import APIRouter, Query
from pydantic import BaseModel

from woodcock_server.retention.due import Rule, due
from woodcock_server.retention.sweeper import measure
from woodcock_server.services import Provided

router = APIRouter(prefix="/api/v1/retention", tags=["retention"])


class DueGroup(BaseModel):
    """A job, or the variants of a comparison; size in bytes."""

    comparison: str | None
    jobs: list[str]
    name: str
    finished_at: datetime
    size: int


class DueFile(BaseModel):
    """An uploaded file that no job names any more; size in bytes."""

    id: str
    name: str
    size: int


class Retention(BaseModel):
    """What would be deleted now, oldest first. days, size: by which rule; kept: bytes that renders and uploads take;
    freed: of these, what deleting frees."""

    days: float | None
    size: int | None
    kept: int
    freed: int
    renders: list[DueGroup]
    files: list[DueFile]


@router.get("")
def ask_retention(
    services: Provided,
    days: Annotated[
        float | None, Query(ge=0, le=36500, description="In place of the service's: since a render's end.")
    ] = None,
    size: Annotated[int | None, Query(ge=0, le=1 << 62, description="In place of the service's: bytes.")] = None,
) -> Retention:
    """What would be deleted by the service's rule, or by another one; nothing is."""
    rule = services.retention if days is None and size is None else Rule(days, size)
    measure(services.engine, services.storage)
    with services.engine.connect() as connection:
        found = due(connection, rule, datetime.now(UTC))
    return Retention(
        days=rule.days,
        size=rule.size,
        kept=found.kept,
        freed=found.freed,
        renders=[DueGroup.model_validate(group, from_attributes=True) for group in found.groups],
        files=[DueFile.model_validate(file, from_attributes=True) for file in found.files],
    )
