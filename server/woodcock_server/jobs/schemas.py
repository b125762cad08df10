"""Jobs as the API shows them."""

from __future__ import annotations

from datetime import datetime
from enum import StrEnum
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field
from sqlalchemy import RowMapping

from woodcock.scene import Scene, Stop

PREFIX = "/api/v1/jobs"

#: What a job asks for that leaves its device to the service; no device's id.
ANY = "any"


class State(StrEnum):
    QUEUED = "queued"  # waits for a dispatcher, perhaps not for the first time
    RUNNING = "running"  # a dispatcher holds its lease
    SUCCEEDED = "succeeded"  # picture and report are there
    FAILED = "failed"  # `error` says why

    @property
    def final(self) -> bool:
        return self in (State.SUCCEEDED, State.FAILED)


class JobCreate(BaseModel):
    """A request to render.

    device: `any` for all that are trusted, or the id of the one that is to render it alone, trusted or not.
    reference: what the picture is held against as it is rendered, of the same size: the id of a job that has succeeded,
    or that of an uploaded picture (sha256:…).
    """

    model_config = ConfigDict(extra="forbid")

    scene: Scene
    name: Annotated[str, Field(max_length=200)] = ""
    device: Annotated[str, Field(max_length=64)] = ANY
    reference: Annotated[str, Field(max_length=71)] | None = None


class Links(BaseModel):
    """Where the job's parts are; null until they exist."""

    self: str
    events: str
    image: str | None
    preview: str | None
    report: str | None
    report_page: str | None


class JobSummary(BaseModel):
    """A job without its scene.

    seconds: rendering time so far; rmse: estimated standard error of a pixel's luminance, in the scene's radiance;
    integrator: that the scene is rendered by, null until it is prepared. The error of one without random numbers
    (transmittance, emission_absorption) is no estimate: it is at most rmse. device: that it asks for, or `any`;
    devices: that have rendered it. reference: that it is held against. waiting: while it is queued, why it would not be
    rendered even if no job were before it.
    """

    id: str
    name: str
    state: State
    waiting: str | None
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None
    width: int
    height: int
    samples: int
    target: Stop
    fraction: float
    seconds: float
    rmse: float | None
    relative_rmse: float | None
    device: str
    devices: list[str]
    reference: str | None
    integrator: str | None
    error: str | None
    links: Links


class Job(JobSummary):
    scene: Scene


class JobPage(BaseModel):
    items: list[JobSummary]
    next: str | None


def summary(row: RowMapping, waiting: str | None = None) -> JobSummary:
    return JobSummary(**_summary(row, waiting))


def job(row: RowMapping, waiting: str | None = None) -> Job:
    return Job(**_summary(row, waiting), scene=row["scene"])


def _summary(row: RowMapping, waiting: str | None) -> dict[str, Any]:
    state, scene = State(row["state"]), row["scene"]
    path = f"{PREFIX}/{row['id']}"
    succeeded = state is State.SUCCEEDED
    return {
        **{key: row[key] for key in JobSummary.model_fields if key in row},
        "waiting": waiting,
        "width": scene["film"]["width"],
        "height": scene["film"]["height"],
        "target": scene["stop"],
        "fraction": 1.0 if succeeded else min(_done(row), 1.0),
        "devices": sorted(row["usage"]),
        "integrator": next((use["kinds"]["integrator"][0] for use in row["usage"].values()), None),
        "links": Links(
            self=path,
            events=f"{path}/events",
            image=f"{path}/image.exr" if succeeded else None,
            # A preview is written before the first samples are counted.
            preview=f"{path}/preview.png" if row["samples"] else None,
            report=f"{path}/report.json" if succeeded else None,
            report_page=f"{path}/report.html" if succeeded else None,
        ),
    }


def _done(row: RowMapping) -> float:
    """Of what the contract asks for, which part is done."""
    stop = row["scene"]["stop"]
    match stop["kind"]:
        case "samples":
            return float(row["samples"] / stop["samples"])
        case "seconds":
            return float(row["seconds"] / stop["seconds"])
        case _:  # Errors fall as 1/√n.
            return float((stop["relative_error"] / row["reached"]) ** 2) if row["reached"] else 0.0
