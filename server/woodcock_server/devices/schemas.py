"""Devices as the API shows them."""

from __future__ import annotations

import math
from datetime import datetime
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator

PREFIX = "/api/v1/devices"


class DeviceLinks(BaseModel):
    """Where the rest of the stability check is; null until one was asked for."""

    stability: str | None


class Device(BaseModel):
    """An OpenCL device of this server, or of a host of the farm; memory in bytes, lanes = the widths that work; speed:
    samples of single pixels a second, of the latest range that it rendered.

    state: `ready`; `distrusted`: its newest stability check failed, so that it renders only jobs that ask for it by its
    id; `failed`: it cannot be used, and fault says why. checked_at, failures: of the newest check that ended, the first
    few sentences of what was wrong.

    job: the id of the one that it renders now; waiting: how many in the queue it may have to render, alone or with
    others.
    """

    id: str
    host: str | None
    name: str
    platform: str
    driver: str
    kind: str
    compute_units: int
    memory: int
    lanes: tuple[int, ...]
    speed: float | None
    state: Literal["ready", "distrusted", "failed"]
    fault: str | None
    stability: Literal["not checked", "running", "passed", "failed"]
    checked_at: datetime | None
    failures: list[str]
    job: str | None
    waiting: int
    links: DeviceLinks


class DeviceList(BaseModel):
    items: list[Device]


def _finite(value: float | None) -> float | None:
    """JSON has no other numbers; what is not finite is told by `says`."""
    return value if value is None or math.isfinite(value) else None


Number = Annotated[float | None, BeforeValidator(_finite)]


class StabilityRow(BaseModel):
    """One case of a check. expected: the exact answer; deviation: got - expected in `unit`; limit: of its size.

    says: what is wrong, or what cannot be expressed; empty where the case passed.
    """

    group: str
    case: str
    expected: Number
    got: Number
    deviation: Number
    unit: str
    limit: Number
    verdict: Literal["passed", "failed", "not expressible"]
    says: str
    seconds: float


class Stability(BaseModel):
    """A stability check of a device; version is Woodcock's.

    started_at: null while it waits for the job that the device renders; finished_at null and rows empty until its end.
    """

    device: str
    state: Literal["running", "passed", "failed"]
    version: str
    started_at: datetime | None
    finished_at: datetime | None
    rows: list[StabilityRow]
