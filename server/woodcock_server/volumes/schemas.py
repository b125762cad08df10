"""Uploaded files as the API shows them."""

from __future__ import annotations

from datetime import datetime
from typing import Literal

from pydantic import BaseModel
from sqlalchemy import RowMapping


class GridSummary(BaseModel):
    """A grid of a volume file; shape in voxels along x, y, z."""

    name: str
    type: str
    shape: tuple[int, int, int]
    voxels: int


class Contents(BaseModel):
    """What a file holds. grids: of a volume; triangles: of a mesh; width, height: of a picture, in pixels."""

    type: Literal["volume", "mesh", "picture"]
    grids: list[GridSummary] = []
    triangles: int | None = None
    width: int | None = None
    height: int | None = None


class Volume(Contents):
    """An uploaded file, and what it holds; its id is its content's hash."""

    id: str
    name: str
    size: int
    created_at: datetime


class GridRange(BaseModel):
    """What is known of a grid once it was read. shape: in voxels along x, y, z, as slices count them; channels: 1 or 3;
    low, high: its least and largest finite value, null where there are none; stride: slices show every so many'th voxel
    of a row, and of a column.
    """

    name: str
    shape: tuple[int, int, int]
    channels: int
    low: float | None
    high: float | None
    stride: int


class VolumePage(BaseModel):
    items: list[Volume]
    next: str | None


def volume(row: RowMapping) -> Volume:
    return Volume(**{key: row[key] for key in Volume.model_fields})
