"""What the service answers of dry runs and of comparisons, as frozen models."""

from __future__ import annotations

from datetime import datetime

from woodcock.scene import Stop
from woodcock_client.models import Answer, State


class ProgramForecast(Answer):
    """What a job would compile; `built`: was it compiled on that device before? `left_out`: lines by file."""

    hash: str
    kinds: dict[str, tuple[str, ...]]
    lanes: int
    source_lines: int
    built: bool
    remained: dict[str, int]
    left_out: dict[str, int]


class MemoryForecast(Answer):
    """Bytes, on the device in all and in one piece, and on the host."""

    device: int
    largest: int
    host: int


class DeviceForecast(Answer):
    """A render by one device alone. What is not known is null, and `says` tells why.

    `fits`: can it render the scene? `reason` says why not. `seconds`: of rendering until the contract is met, between
    `low` and `high` with 95 % confidence; `high` is null where it has no bound. `error`: estimated at the end, relative
    to the mean luminance.
    """

    id: str
    fits: bool | None = None
    reason: str | None = None
    read_seconds: float | None = None
    build_seconds: float | None = None
    seconds: float | None = None
    low: float | None = None
    high: float | None = None
    samples: float | None = None
    error: float | None = None
    says: str = ""


class JobCheck(Answer):
    """A dry run of a job: nothing was queued."""

    contract: Stop
    program: ProgramForecast | None = None
    memory: MemoryForecast | None = None
    devices: tuple[DeviceForecast, ...] = ()


class ComparedJob(Answer):
    """The job of a variant; `choices`: the kind of every field that varies."""

    id: str
    label: str
    choices: dict[str, str]
    state: State
    error: str | None = None


class Ratio(Answer):
    """With its 95 % interval, null where it is not known."""

    value: float
    low: float | None = None
    high: float | None = None


class ComparedRow(Answer):
    """What came of a variant. `efficiency`: 1 / (variance × seconds), null without noise; `ratio`: over the worst's."""

    label: str
    job: str
    seconds: float
    build_seconds: float
    samples: float
    rmse: float | None = None
    deterministic: bool = False
    efficiency: float | None = None
    ratio: Ratio | None = None


class Verdict(Answer):
    """Who wins, null if nobody; `disagree`: those whose picture is another one; `order`: best first."""

    winner: str | None = None
    draw: tuple[str, ...] = ()
    disagree: tuple[str, ...] = ()
    order: tuple[str, ...] = ()
    lead: Ratio | None = None
    says: str


class ComparisonLinks(Answer):
    self: str
    report: str | None = None


class Comparison(Answer):
    """Variants of a scene, each rendered for so many seconds. `rows`, `verdict`: null until all jobs have ended."""

    id: str
    name: str
    state: State
    created_at: datetime
    device: str
    seconds: float
    vary: dict[str, tuple[str, ...]]
    reference: str | None = None
    jobs: tuple[ComparedJob, ...]
    rows: tuple[ComparedRow, ...] | None = None
    verdict: Verdict | None = None
    links: ComparisonLinks

    @property
    def finished(self) -> bool:
        """True when nothing about it will change any more."""
        return self.state in ("succeeded", "failed")
