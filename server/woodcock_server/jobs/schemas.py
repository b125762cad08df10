"""Jobs as the API shows them."""

from __future__ import annotations

from datetime import datetime
from enum import StrEnum
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field
from sqlalchemy import RowMapping

from woodcock.scene import Scene, Stop

PREFIX = "/api/v1/jobs"


class State(StrEnum):
    QUEUED = "queued"  # waits for a dispatcher, perhaps not for the first time
    RUNNING = "running"  # a dispatcher holds its lease
    SUCCEEDED = "succeeded"  # picture and report are there
    FAILED = "failed"  # `error` says why

    @property
    def final(self) -> bool:
        return self in (State.SUCCEEDED, State.FAILED)


class JobCreate(BaseModel):
    """A request to render."""

    model_config = ConfigDict(extra="forbid")

    scene: Scene
    name: Annotated[str, Field(max_length=200)] = ""


class Links(BaseModel):
    """Where the job's parts are; null until they exist."""

    self: str
    events: str
    image: str | None
    preview: str | None
    report: str | None


class JobSummary(BaseModel):
    """A job without its scene.

    seconds: rendering time so far; rmse: estimated standard error of a pixel's luminance, in the scene's radiance;
    integrator: that the scene is rendered by, null until it is prepared. The error of one without random numbers
    (transmittance, emission_absorption) is no estimate: it is at most rmse.
    """

    id: str
    name: str
    state: State
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
    devices: list[str]
    integrator: str | None
    error: str | None
    links: Links


class Job(JobSummary):
    scene: Scene


class JobPage(BaseModel):
    items: list[JobSummary]
    next: str | None


def summary(row: RowMapping) -> JobSummary:
    return JobSummary(**_summary(row))


def job(row: RowMapping) -> Job:
    return Job(**_summary(row), scene=row["scene"])


def _summary(row: RowMapping) -> dict[str, Any]:
    state, scene = State(row["state"]), row["scene"]
    path = f"{PREFIX}/{row['id']}"
    succeeded = state is State.SUCCEEDED
    stop = scene["stop"]
    done = row["samples"] / stop["samples"] if stop["kind"] == "samples" else row["seconds"] / stop["seconds"]
    return {
        **{key: row[key] for key in JobSummary.model_fields if key in row},
        "width": scene["film"]["width"],
        "height": scene["film"]["height"],
        "target": stop,
        "fraction": 1.0 if succeeded else min(done, 1.0),
        "devices": sorted(row["usage"]),
        "integrator": next((use["kinds"]["integrator"][0] for use in row["usage"].values()), None),
        "links": Links(
            self=path,
            events=f"{path}/events",
            image=f"{path}/image.exr" if succeeded else None,
            # A preview is written before the first samples are counted.
            preview=f"{path}/preview.png" if row["samples"] else None,
            report=f"{path}/report.json" if succeeded else None,
        ),
    }
