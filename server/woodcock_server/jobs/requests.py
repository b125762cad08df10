"""Can what is asked for be rendered here?"""

from __future__ import annotations

from functools import cache

from sqlalchemy import RowMapping

from woodcock.denoise import DenoiseError, require
from woodcock.scene import Scene
from woodcock_server.devices.choice import ANY, KINDS, meant
from woodcock_server.jobs import reference
from woodcock_server.jobs.schemas import JobCreate
from woodcock_server.problems import Fault, InvalidRequest
from woodcock_server.services import Services
from woodcock_server.volumes import repository as volumes
from woodcock_server.volumes.check import check_scene


class RequestCheck:
    """Of one request or several; what they name in common is looked up once."""

    def __init__(self, services: Services) -> None:
        self._services = services
        self._volume = cache(self._find_volume)
        self._reference_fault = cache(self._find_reference_fault)

    def check(self, request: JobCreate) -> None:
        """Raises InvalidRequest for what cannot be rendered here."""
        self.check_device(request.device)
        check_scene(self._volume, request.scene)
        _check_denoiser(request.scene)
        if request.reference is not None:
            self._check_reference(request.reference, request.scene)

    def check_device(self, asked: str) -> None:
        """Raises InvalidRequest for a device that there is not, or that cannot be used."""
        devices = self._services.devices
        found = meant(asked, devices)
        if asked == ANY or any(device.ready for device in found):
            return
        if self._services.cluster.remote and asked in KINDS:  # One may come.
            return
        if found:
            message = f"{asked} cannot be used: {found[0].probe.fault}"
        else:
            known = ", ".join(sorted({name for device in devices for name in (device.device.kind, device.id)}))
            message = f"must be {ANY}, or the kind or id of a device of this server: {known or 'there is none'}"
        raise InvalidRequest("The job cannot have the device that it asks for.", Fault(field="device", message=message))

    def _check_reference(self, asked: str, scene: Scene) -> None:
        message = self._reference_fault(asked, scene.film.width, scene.film.height)
        if message is not None:
            fault = Fault(field="reference", message=message)
            raise InvalidRequest("The picture cannot be held against this reference.", fault)

    def _find_volume(self, volume_id: str) -> RowMapping | None:
        with self._services.engine.connect() as connection:
            return volumes.get(connection, volume_id)

    def _find_reference_fault(self, asked: str, width: int, height: int) -> str | None:
        return reference.fault(self._services.engine, self._services.storage, asked, width, height)


def _check_denoiser(scene: Scene) -> None:
    """Raises InvalidRequest for a scene whose picture could not be denoised here."""
    try:
        if scene.denoise:
            require()
    except DenoiseError as error:
        fault = Fault(field="scene.denoise", message=str(error))
        raise InvalidRequest("The picture cannot be denoised by this service.", fault) from None
