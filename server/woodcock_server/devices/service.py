"""Which devices there are, and which of them are to be trusted."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import structlog

from woodcock import __version__
from woodcock import device as opencl
from woodcock.probe import Probe, probe

log = structlog.get_logger()


@dataclass(frozen=True)
class Found:
    """A device of this server, as it was when that started.

    fingerprint: of what outcomes of its stability checks depend on, 64 hex digits.
    """

    device: opencl.Device
    probe: Probe
    fingerprint: str

    @property
    def id(self) -> str:
        return self.device.id

    @property
    def ready(self) -> bool:
        return bool(self.probe.lanes)


def discover() -> list[Found]:
    """Every device, checked in child processes, all at once; blocks for seconds the first time on a machine."""
    try:
        found = opencl.devices()
    except opencl.DeviceError as error:
        log.warning("no device to render on", reason=str(error))
        return []
    with ThreadPoolExecutor(len(found)) as pool:
        probes = list(pool.map(probe, found))
    devices = [Found(*each) for each in zip(found, probes, fingerprints(found), strict=True)]
    for one in devices:
        if one.ready:
            log.info("device ready", device=one.id, name=one.device.name, lanes=one.probe.lanes)
        else:
            log.warning("device failed its check", device=one.id, name=one.device.name, fault=one.probe.fault)
    return devices


def fingerprints(devices: Sequence[opencl.Device]) -> list[str]:
    """Of each device, in order. Two of the same make are told apart by their order, for one of them may be broken."""
    identities = [device.identity for device in devices]
    return [
        hashlib.sha256(f"{identity}|{identities[:position].count(identity)}|{__version__}".encode()).hexdigest()
        for position, identity in enumerate(identities)
    ]
