"""What the service answers of batches, as frozen models."""

from __future__ import annotations

from datetime import datetime

from pydantic import JsonValue

from woodcock.scene import Scene
from woodcock_client.models import FINAL, Answer, Links, State


class Axis(Answer):
    """What changes together: in each row a value for each path."""

    paths: tuple[str, ...]
    rows: tuple[tuple[JsonValue, ...], ...]


class BatchJob(Answer):
    """A job of a batch, in short; `point` has the value of every path that is swept."""

    id: str
    point: dict[str, JsonValue]
    state: State
    waiting: str | None = None
    fraction: float
    samples: int
    seconds: float
    relative_rmse: float | None = None
    retry_of: str | None = None
    extends: str | None = None
    error: str | None = None
    links: Links

    @property
    def finished(self) -> bool:
        """True when nothing about it will change any more."""
        return self.state in FINAL


class BatchLinks(Answer):
    self: str
    jobs: str


class Batch(Answer):
    """A scene at every point of a sweep.

    `axes` has the zipped paths as one, then each of the product; `jobs` are in that order, the last axis changing
    fastest, then those that were tried again or extended.
    """

    id: str
    name: str
    created_at: datetime
    scene: Scene
    axes: tuple[Axis, ...]
    counts: dict[State, int]
    jobs: tuple[BatchJob, ...]
    links: BatchLinks

    @property
    def finished(self) -> bool:
        """True when all of its jobs have ended."""
        return all(job.finished for job in self.jobs)

    @property
    def fraction(self) -> float:
        """Of all that is to be rendered, which part is done or given up, 0 to 1."""
        return sum(1.0 if job.finished else job.fraction for job in self.jobs) / max(len(self.jobs), 1)
