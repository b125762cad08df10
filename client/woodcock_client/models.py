"""What the service answers, as frozen models.

Keys that this client does not know are ignored, so that an older client can read a newer service.
"""

from __future__ import annotations

from datetime import datetime
from typing import Literal

from pydantic import BaseModel, ConfigDict

from woodcock.scene import Scene, Stop

State = Literal["queued", "running", "cancelling", "succeeded", "failed", "cancelled"]
FINAL: tuple[State, ...] = ("succeeded", "failed", "cancelled")


class Answer(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class Links(Answer):
    """Addresses of a job's parts; null until the part exists."""

    self: str
    events: str
    image: str | None = None
    preview: str | None = None
    layers: str | None = None
    report: str | None = None
    report_page: str | None = None


class Webhook(Answer):
    """How it stands with telling `url` of a job's end; `error` says why the newest of the `attempts` failed."""

    url: str
    state: Literal["waiting", "delivered", "given up"]
    attempts: int
    error: str | None = None


class JobSummary(Answer):
    """A job as listings and events show it.

    `fraction` runs from 0 to 1 along `target`; `seconds` is rendering time so far. `rmse` is the estimated standard
    error of a pixel's luminance (root mean square over the picture, in the scene's unit of radiance), and
    `relative_rmse` the same over the picture's mean luminance; both are null until they can be estimated. Where
    `deterministic`, there is no noise and they are what the error is at most. `integrator` is null until it is known.
    `device` is the one that was asked for, or "any"; `devices` have rendered it. `reference` is what its picture is
    held against, if anything. `retry_of` is the job that this one does once more, `extends` the one whose
    samples it goes on from. `webhook` is who is told of its end, if anybody. `waiting` says why a queued job would not
    be rendered even if no other were before it.
    """

    id: str
    name: str
    tags: tuple[str, ...] = ()
    priority: int = 0
    state: State
    waiting: str | None = None
    created_at: datetime
    started_at: datetime | None = None
    finished_at: datetime | None = None
    width: int
    height: int
    samples: int
    target: Stop
    fraction: float
    seconds: float
    rmse: float | None = None
    relative_rmse: float | None = None
    device: str = "any"
    devices: tuple[str, ...] = ()
    reference: str | None = None
    retry_of: str | None = None
    extends: str | None = None
    webhook: Webhook | None = None
    integrator: str | None = None
    error: str | None = None
    links: Links

    @property
    def deterministic(self) -> bool:
        """True of a picture that is computed without random numbers."""
        return self.integrator in ("transmittance", "emission_absorption")

    @property
    def finished(self) -> bool:
        """True when nothing about the job will change any more."""
        return self.state in FINAL


class Job(JobSummary):
    """A job with the scene it renders."""

    scene: Scene


class JobPage(Answer):
    items: tuple[JobSummary, ...]
    next: str | None = None


class Grid(Answer):
    """One grid of a volume file; `shape` is its extent in voxels along x, y, z, `voxels` how many are stored."""

    name: str
    type: str
    shape: tuple[int, int, int]
    voxels: int


class Volume(Answer):
    """An uploaded file; `id` is `sha256:` and the digest of its bytes, `size` their number.

    `type` says what it holds: a volume has `grids`, a mesh `triangles`, a picture `width` and `height` in pixels.
    """

    id: str
    type: str = "volume"
    name: str
    size: int
    created_at: datetime
    grids: tuple[Grid, ...] = ()
    triangles: int | None = None
    width: int | None = None
    height: int | None = None


class Device(Answer):
    """A device the service renders on.

    `memory` in bytes; `lanes` the vector widths that work. `state`: "failed" devices cannot be used, and `fault` says
    why; "distrusted" ones failed their newest stability check, and render only jobs that ask for them. `checked_at` and
    `failures` are of that check; `failures` holds its first sentences, `Client.stability` the rest.
    """

    id: str
    name: str
    platform: str
    driver: str
    kind: str
    compute_units: int
    memory: int
    lanes: tuple[int, ...] = ()
    state: Literal["ready", "distrusted", "failed"]
    fault: str | None = None
    stability: Literal["not checked", "running", "passed", "failed"] = "not checked"
    checked_at: datetime | None = None
    failures: tuple[str, ...] = ()


class DeviceList(Answer):
    items: tuple[Device, ...]


class StabilityRow(Answer):
    """One stiff or extreme case, held against its exact answer.

    `deviation` is got - expected in `unit`, and `limit` what its size may be; null where nothing could be compared.
    `says` is what is wrong, or what cannot be expressed; empty where the case passed.
    """

    group: str
    case: str
    expected: float | None = None
    got: float | None = None
    deviation: float | None = None
    unit: str
    limit: float | None = None
    verdict: Literal["passed", "failed", "not expressible"]
    says: str = ""
    seconds: float


class Stability(Answer):
    """A stability check of a device, by Woodcock's `version`.

    `started_at` is null while it waits for the job that the device renders; `rows` come with its end.
    """

    device: str
    state: Literal["running", "passed", "failed"]
    version: str
    started_at: datetime | None = None
    finished_at: datetime | None = None
    rows: tuple[StabilityRow, ...] = ()


class FieldError(Answer):
    """One fault of a request: the field, as the request is written, and what would be right."""

    field: str
    message: str


class Problem(Answer):
    """RFC 9457 problem details."""

    title: str = ""
    status: int = 0
    detail: str = ""
    errors: tuple[FieldError, ...] | None = None
