"""Batches as the API shows them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from datetime import datetime
from typing import Any

from pydantic import BaseModel, Field, JsonValue

from woodcock.scene import Scene
from woodcock_server.batches import sweep
from woodcock_server.jobs import schemas as jobs
from woodcock_server.jobs.schemas import JobCreate
from woodcock_server.jobs.states import State

PREFIX = "/api/v1/batches"

#: Path -> values.
Axes = dict[str, list[JsonValue]]


class BatchCreate(JobCreate):
    """A request to render a scene at every combination of values of some of its fields, 1000 at most.

    product: values of fields, each named as a fault of the scene would name it (`volumes[0].sigma_t`); each is combined
    with all others. zip: lists of one length that go together, and are combined with the product as one. The order is
    that of loops: the zipped values outermost, then the product's fields as they are written; the last one changes
    fastest. All else is as of a job, and the same for every one.
    """

    product: Axes = Field(default_factory=dict)
    zip: Axes = Field(default_factory=dict)


class Axis(BaseModel):
    """What changes together: in each row a value for each path."""

    paths: list[str]
    rows: list[list[JsonValue]]


class BatchJob(BaseModel):
    """A job of a batch, in short; every field is as the job has it."""

    id: str
    point: dict[str, JsonValue]
    state: State
    waiting: str | None
    fraction: float
    samples: int
    seconds: float
    relative_rmse: float | None
    integrator: str | None
    retry_of: str | None
    extends: str | None
    error: str | None
    links: jobs.Links


class Links(BaseModel):
    """jobs: the listing of its jobs, newest first."""

    self: str
    jobs: str


class BatchSummary(BaseModel):
    """owner: as of its jobs; counts: of these, by state."""

    id: str
    owner: str
    name: str
    created_at: datetime
    counts: dict[State, int]
    links: Links


class Batch(BatchSummary):
    """scene: that is swept; axes: the zipped fields, if any, then each of the product; jobs: in the order of the sweep,
    then those that were tried again or extended."""

    scene: Scene
    axes: list[Axis]
    jobs: list[BatchJob]


class BatchPage(BaseModel):
    items: list[BatchSummary]
    next: str | None


def summary(row: Mapping[str, Any], counts: Mapping[State, int]) -> BatchSummary:
    return BatchSummary(**_summary(row, counts))


def batch(row: Mapping[str, Any], rows: Iterable[tuple[Mapping[str, Any], str | None]]) -> Batch:
    """rows: of its jobs, each with why it waits."""
    shown = [_job(*each) for each in rows]
    states = [each.state for each in shown]
    swept = sweep.axes(row["product"], row["zip"])
    return Batch(
        **_summary(row, {state: states.count(state) for state in State}),
        scene=row["scene"],
        axes=[Axis(paths=list(axis.paths), rows=[list(each) for each in axis.rows]) for axis in swept],
        jobs=shown,
    )


def _summary(row: Mapping[str, Any], counts: Mapping[State, int]) -> dict[str, Any]:
    links = Links(self=f"{PREFIX}/{row['id']}", jobs=f"{jobs.PREFIX}?batch={row['id']}")
    return {**{key: row[key] for key in ("id", "owner", "name", "created_at")}, "counts": counts, "links": links}


def _job(row: Mapping[str, Any], waiting: str | None) -> BatchJob:
    own = {key: row[key] for key in BatchJob.model_fields if key in row}
    return BatchJob(**own, waiting=waiting, fraction=jobs.fraction(row), links=jobs.links(row))
