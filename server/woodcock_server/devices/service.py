"""Which devices there are, and which of them are to be trusted."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import structlog

from woodcock import device as opencl
from woodcock.probe import probe
from woodcock_server.devices.schemas import Device

log = structlog.get_logger()


def discover() -> list[Device]:
    """Every device, checked in child processes, all at once; blocks for seconds the first time on a machine."""
    try:
        found = opencl.devices()
    except opencl.DeviceError as error:
        log.warning("no device to render on", reason=str(error))
        return []
    with ThreadPoolExecutor(len(found)) as pool:
        checked = list(pool.map(_check, found))
    for device in checked:
        if device.state == "ready":
            log.info("device ready", device=device.id, name=device.name, lanes=device.lanes)
        else:
            log.warning("device failed its check", device=device.id, name=device.name, fault=device.fault)
    return checked


def _check(device: opencl.Device) -> Device:
    result = probe(device)
    return Device(
        id=device.id,
        name=device.name,
        platform=device.platform,
        driver=device.driver,
        kind=device.kind,
        compute_units=device.compute_units,
        memory=device.memory,
        lanes=result.lanes,
        state="ready" if result.lanes else "failed",
        fault=result.fault,
    )
