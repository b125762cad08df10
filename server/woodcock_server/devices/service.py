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
    """A device of this server, or of a worker host, as it was when that started.

    fingerprint: of what outcomes of its stability checks depend on, 64 hex digits; host: empty for this server's own.
    """

    device: opencl.Device
    probe: Probe
    fingerprint: str
    host: str = ""

    @property
    def id(self) -> str:
        """Unlike that of any other host's devices: `gpu0@node7`."""
        return f"{self.device.id}@{self.host}" if self.host else self.device.id

    @property
    def ready(self) -> bool:
        return bool(self.probe.lanes)


def discover(host: str = "") -> list[Found]:
    """Every device, checked in child processes, all at once; blocks for seconds the first time on a machine.

    host: the name of this machine in a farm.
    """
    try:
        found = opencl.devices()
    except opencl.DeviceError as error:
        log.warning("no device to render on", reason=str(error))
        return []
    with ThreadPoolExecutor(len(found)) as pool:
        probes = list(pool.map(probe, found))
    devices = [Found(*each, host) for each in zip(found, probes, fingerprints(found, host), strict=True)]
    for one in devices:
        if one.ready:
            log.info("device ready", device=one.id, name=one.device.name, lanes=one.probe.lanes)
        else:
            log.warning("device failed its check", device=one.id, name=one.device.name, fault=one.probe.fault)
    return devices


def fingerprints(devices: Sequence[opencl.Device], host: str = "") -> list[str]:
    """Of each device, in order. Two of the same make are told apart by their order, and in a farm by their hosts, for
    one of them may be broken."""
    place = f"|{host}" if host else ""
    identities = [device.identity for device in devices]
    return [
        hashlib.sha256(f"{identity}|{identities[:position].count(identity)}|{__version__}{place}".encode()).hexdigest()
        for position, identity in enumerate(identities)
    ]
