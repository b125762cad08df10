"""/api/v1/devices"""

from __future__ import annotations

from fastapi import APIRouter

from woodcock_server.devices.schemas import DeviceList
from woodcock_server.services import Provided

router = APIRouter(prefix="/api/v1/devices", tags=["devices"])


@router.get("")
def list_devices(services: Provided) -> DeviceList:
    """The OpenCL devices of this server, as they were when it started."""
    return DeviceList(items=services.devices)
