"""Jobs as the API shows them."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, JsonValue

from woodcock.scene import Scene, Stop
from woodcock_server.devices.choice import ANY
from woodcock_server.jobs.states import State
from woodcock_server.names import ONE_LINE
from woodcock_server.webhooks.schemas import Delivery, Webhook

PREFIX = "/api/v1/jobs"


Name = Annotated[str, Field(max_length=200), ONE_LINE]
Tag = Annotated[str, Field(min_length=1, max_length=64), ONE_LINE]
#: Once each, sorted.
Tags = Annotated[
    tuple[Tag, ...],
    Field(max_length=20),
    AfterValidator(lambda tags: tuple(sorted(set(tags)))),
]
Priority = Annotated[int, Field(ge=-100, le=100, strict=True)]


class JobCreate(BaseModel):
    """A request to render.

    tags: words to find it by; priority: jobs of a higher one are rendered first; of the same, those of whoever had
    least lately, in turn. pinned: it is not deleted for its age or for want of room.
    device: `any` for all that are trusted, a kind (`cpu`, `gpu`, `accelerator`) for those of that kind, or the id of
    the one that is to render it alone, trusted or not.
    reference: what the picture is held against as it is rendered, of the same size: the id of a job that has succeeded,
    or that of an uploaded picture (sha256:…). webhook: who is to be told of the end.
    """

    model_config = ConfigDict(extra="forbid")

    scene: Scene
    name: Name = ""
    tags: Tags = ()
    priority: Priority = 0
    pinned: Annotated[bool, Field(strict=True)] = False
    device: Annotated[str, Field(max_length=64)] = ANY
    reference: Annotated[str, Field(max_length=71)] | None = None
    webhook: Webhook | None = None


class JobChange(BaseModel):
    """What is to be changed of a job; what is left out stays as it is."""

    model_config = ConfigDict(extra="forbid")

    name: Name = ""
    tags: Tags = ()
    priority: Priority = 0
    pinned: Annotated[bool, Field(strict=True)] = False

    @property
    def columns(self) -> dict[str, Any]:
        """What was given."""
        return self.model_dump(mode="json", exclude_unset=True)


class JobsToDelete(BaseModel):
    """ids: of jobs, 1000 at most."""

    model_config = ConfigDict(extra="forbid")

    ids: Annotated[list[Annotated[str, Field(max_length=36), ONE_LINE]], Field(min_length=1, max_length=1000)]


class JobsDeleted(BaseModel):
    """deleted: ids of jobs that are no more, those among them that had not been there; kept: why each of the others
    stays, by id."""

    deleted: list[str]
    kept: dict[str, str]


class JobExtension(BaseModel):
    """stop: of the kind that the job had, and stricter."""

    model_config = ConfigDict(extra="forbid")

    stop: Stop


class Links(BaseModel):
    """Where the job's parts are; null until they exist."""

    self: str
    events: str
    image: str | None
    preview: str | None
    thumbnail: str | None
    report: str | None
    report_page: str | None


class JobSummary(BaseModel):
    """A job without its scene.

    owner: of the token that asked for it, empty where none was needed; pinned: it stays, however old it is.

    seconds: rendering time so far; rmse: estimated standard error of a pixel's luminance, in the scene's radiance;
    integrator: that the scene is rendered by, null until it is prepared. The error of one without random numbers
    (transmittance, emission_absorption) is no estimate: it is at most rmse. device: that it asks for, or `any`;
    devices: that have rendered it. reference: that it is held against. waiting: while it is queued, why it would not be
    rendered even if no job were before it. batch: that it is of; point: the values of what is swept, by path.
    retry_of: the job that this one does once more; extends: the one whose samples it goes on from. webhook: how it
    stands with telling the job's end, if that was asked for.
    """

    id: str
    owner: str
    name: str
    tags: list[str]
    priority: int
    pinned: bool
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
    batch: str | None
    point: dict[str, JsonValue] | None
    retry_of: str | None
    extends: str | None
    webhook: Delivery | None
    integrator: str | None
    error: str | None
    links: Links


class JobEvent(BaseModel):
    """A state that a job came to."""

    state: State
    at: datetime


class Job(JobSummary):
    scene: Scene


class JobPage(BaseModel):
    items: list[JobSummary]
    next: str | None


class JobCounts(BaseModel):
    """How many jobs there are: in each state, with each tag, rendered on each device, and by each integrator. Of tags,
    devices and integrators the 200 of which there are most."""

    states: dict[State, int]
    tags: dict[str, int]
    devices: dict[str, int]
    integrators: dict[str, int]


def summary(row: Mapping[str, Any], waiting: str | None = None) -> JobSummary:
    return JobSummary(**_summary(row, waiting))


def job(row: Mapping[str, Any], waiting: str | None = None) -> Job:
    return Job(**_summary(row, waiting), scene=row["scene"])


def _summary(row: Mapping[str, Any], waiting: str | None) -> dict[str, Any]:
    scene = row["scene"]
    return {
        **{key: row[key] for key in JobSummary.model_fields if key in row},
        "waiting": waiting,
        "width": scene["film"]["width"],
        "height": scene["film"]["height"],
        "target": scene["stop"],
        "fraction": fraction(row),
        "links": links(row),
    }


def links(row: Mapping[str, Any]) -> Links:
    path = f"{PREFIX}/{row['id']}"
    succeeded = row["state"] == State.SUCCEEDED
    return Links(
        self=path,
        events=f"{path}/events",
        image=f"{path}/image.exr" if succeeded else None,
        # They are written before the first samples are counted.
        preview=f"{path}/preview.png" if row["samples"] else None,
        thumbnail=f"{path}/thumbnail.webp" if row["samples"] else None,
        report=f"{path}/report.json" if succeeded else None,
        report_page=f"{path}/report.html" if succeeded else None,
    )


def fraction(row: Mapping[str, Any]) -> float:
    """Of what the contract asks for, which part is done, 0 to 1."""
    return 1.0 if row["state"] == State.SUCCEEDED else min(_done(row), 1.0)


def _done(row: Mapping[str, Any]) -> float:
    stop = row["scene"]["stop"]
    match stop["kind"]:
        case "samples":
            return float(row["samples"] / stop["samples"])
        case "seconds":
            return float(row["seconds"] / stop["seconds"])
        case _:  # Errors fall as 1/√n.
            return float((stop["relative_error"] / row["reached"]) ** 2) if row["reached"] else 0.0
