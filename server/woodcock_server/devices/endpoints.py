"""/api/v1/devices"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from fastapi import APIRouter, Depends, HTTPException, Response
from sqlalchemy import RowMapping

from woodcock import __version__
from woodcock_server.access.guard import administrator
from woodcock_server.devices import repository
from woodcock_server.devices.choice import leaves_a_choice, meant
from woodcock_server.devices.schemas import PREFIX, Device, DeviceLinks, DeviceList, Stability
from woodcock_server.devices.service import Found
from woodcock_server.jobs import repository as jobs
from woodcock_server.problems import problem_schema
from woodcock_server.services import Provided, Services

router = APIRouter(prefix=PREFIX, tags=["devices"])

#: How many of a failed check's sentences the list of devices shows.
FEW = 3


def _existing(id: str, services: Provided) -> Found:
    for device in services.devices:
        if device.id == id:
            return device
    known = ", ".join(device.id for device in services.devices) or "none"
    raise HTTPException(404, f"There is no device {id}; there are: {known}.")


Existing = Annotated[Found, Depends(_existing)]


@router.get("")
def list_devices(services: Provided) -> DeviceList:
    """The OpenCL devices of this server, or of the farm's workers as they come and go, and how their stability checks
    ended."""
    with services.engine.connect() as connection:
        outcomes = repository.newest(connection, [device.fingerprint for device in services.devices])
        asked = jobs.waiting(connection)
    return DeviceList(items=[_shown(one, outcomes.get(one.fingerprint), asked, services) for one in services.devices])


@router.post(
    "/{id}/stability",
    status_code=202,
    dependencies=[Depends(administrator)],
    responses=problem_schema(404, 409),
)
async def check_stability(device: Existing, response: Response, services: Provided) -> Stability:
    """Render stiff and extreme scenes on the device and hold them against exact answers. The check begins once no job
    renders on the device, which gets no other until it has ended; it takes minutes. One that is under way is not begun
    again.
    """
    if not device.ready:
        raise HTTPException(409, f"{device.id} cannot be used: {device.probe.fault}")
    services.checks.ask(device.id)
    response.headers["Location"] = _link(device)
    return _under_way(device, services)


@router.get("/{id}/stability", responses=problem_schema(404))
def get_stability(device: Existing, services: Provided) -> Stability:
    """The device's stability check that is under way, or else the newest outcome."""
    if device.id in services.checks.under_way:
        return _under_way(device, services)
    with services.engine.connect() as connection:
        row = repository.newest(connection, [device.fingerprint]).get(device.fingerprint)
    if row is None:
        raise HTTPException(404, f"{device.id} is not checked; a POST to {_link(device)} checks it.")
    state = "passed" if row["passed"] else "failed"
    return Stability(device=device.id, state=state, **{key: row[key] for key in Stability.model_fields if key in row})


def _under_way(device: Found, services: Services) -> Stability:
    started = services.checks.under_way.get(device.id)
    return Stability(
        device=device.id, state="running", version=__version__, started_at=started, finished_at=None, rows=[]
    )


def _shown(found: Found, outcome: RowMapping | None, asked: Mapping[str, int], services: Services) -> Device:
    """asked: of the jobs that wait, how many ask for which device."""
    device, passed = found.device, outcome is None or outcome["passed"]
    running = found.id in services.checks.under_way
    failures = [row for row in outcome["rows"] if row["verdict"] == "failed"] if outcome else []
    able = [ask for ask in asked if found.ready and meant(ask, [found]) and (passed or not leaves_a_choice(ask))]
    return Device(
        id=found.id,
        host=found.host or None,
        name=device.name,
        platform=device.platform,
        driver=device.driver,
        kind=device.kind,
        compute_units=device.compute_units,
        memory=device.memory,
        lanes=found.probe.lanes,
        speed=services.metrics.speeds.get(found.id),
        state="failed" if not found.ready else "ready" if passed else "distrusted",
        fault=found.probe.fault,
        stability="running" if running else "not checked" if outcome is None else "passed" if passed else "failed",
        checked_at=outcome and outcome["finished_at"],
        failures=[f"{row['group']}, {row['case']}: {row['says']}" for row in failures[:FEW]],
        job=services.dispatcher.at_work.get(found.id),
        waiting=sum(asked[ask] for ask in able),
        links=DeviceLinks(stability=_link(found) if running or outcome else None),
    )


def _link(device: Found) -> str:
    return f"{PREFIX}/{device.id}/stability"
