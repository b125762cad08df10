"""Volumes as the API shows them."""

from __future__ import annotations

from datetime import datetime

from pydantic import BaseModel
from sqlalchemy import RowMapping


class GridSummary(BaseModel):
    """A grid of a volume file; shape in voxels along x, y, z."""

    name: str
    type: str
    shape: tuple[int, int, int]
    voxels: int


class Volume(BaseModel):
    """An uploaded file; its id is its content's hash."""

    id: str
    name: str
    size: int
    created_at: datetime
    grids: list[GridSummary]


class VolumePage(BaseModel):
    items: list[Volume]
    next: str | None


def volume(row: RowMapping) -> Volume:
    return Volume(
        id=row["id"],
        name=row["name"],
        size=row["size"],
        created_at=row["created_at"],
        grids=[GridSummary(**grid) for grid in row["grids"]],
    )
