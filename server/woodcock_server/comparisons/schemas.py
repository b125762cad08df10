"""Comparisons as the API shows them."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from woodcock.scene import Scene
from woodcock_server.devices.choice import ANY
from woodcock_server.jobs.schemas import Name
from woodcock_server.jobs.states import State

PREFIX = "/api/v1/comparisons"

#: Jobs that one request may make.
MOST_VARIANTS = 16


class ComparisonCreate(BaseModel):
    """A request to render a scene in variants, each for so many seconds, one after the other on one device.

    vary: kinds to try of `majorant`, `free_flight`, `transmittance` or `integrator`; every combination is a variant, 16
    at most. seconds: wall time of rendering of each; the scene's own contract does not count. device: `any` for the
    first that is trusted. reference: as of a job.
    """

    model_config = ConfigDict(extra="forbid")

    scene: Scene
    vary: Annotated[dict[str, list[str]], Field(min_length=1)]
    seconds: Annotated[float, Field(ge=0.1, le=86400)]
    name: Name = ""
    device: Annotated[str, Field(max_length=64)] = ANY
    reference: Annotated[str, Field(max_length=71)] | None = None


class Ratio(BaseModel):
    """low, high: the 95 % interval; null where it is not known."""

    value: float
    low: float | None
    high: float | None


class ComparedJob(BaseModel):
    """The job of a variant. choices: the kind of every field that varies."""

    id: str
    label: str
    choices: dict[str, str]
    state: State
    error: str | None
    link: str


class Row(BaseModel):
    """What came of a variant. seconds: of rendering, wall clock; build_seconds: of read, build and upload, which do not
    count.

    efficiency: 1 / (variance × the device's seconds), null without noise; ratio: over that of the verdict's `worst`.
    against: what the report says of the reference.
    """

    label: str
    choices: dict[str, str]
    job: str
    seconds: float
    build_seconds: float
    samples: float
    rmse: float | None
    deterministic: bool
    efficiency: float | None
    ratio: Ratio | None
    against: dict[str, Any] | None


class Verdict(BaseModel):
    """winner: its label, null where nobody wins; draw: those that may each be the best, where there is no winner.

    disagree: those whose picture is not the others', or not the reference's; they cannot win. order: best first.
    runner_up, lead: whom the winner beats, and by which ratio. same: variants that were left out, each with the one
    that is the same program.
    """

    winner: str | None
    draw: list[str]
    disagree: list[str]
    order: list[str]
    worst: str | None
    runner_up: str | None
    lead: Ratio | None
    same: dict[str, str]
    says: str


class Links(BaseModel):
    """report: the page; null until all jobs have ended, and where fewer than two variants could be compared."""

    self: str
    report: str | None


class Comparison(BaseModel):
    """owner: as of its jobs; state: failed if fewer than two of these succeeded; rows, verdict: null until all have
    ended."""

    id: str
    owner: str
    name: str
    state: State
    created_at: datetime
    device: str
    seconds: float
    vary: dict[str, list[str]]
    reference: str | None
    jobs: list[ComparedJob]
    rows: list[Row] | None
    verdict: Verdict | None
    links: Links
