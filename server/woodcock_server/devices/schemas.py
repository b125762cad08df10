"""Devices as the API shows them."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel


class Device(BaseModel):
    """An OpenCL device of this server; memory in bytes, lanes = the widths that work."""

    id: str
    name: str
    platform: str
    driver: str
    kind: str
    compute_units: int
    memory: int
    lanes: tuple[int, ...]
    state: Literal["ready", "failed"]
    fault: str | None


class DeviceList(BaseModel):
    items: list[Device]
