"""Dry runs: what a job would compile, take and last, before it is submitted. Nothing is queued or stored.

A device that renders a job is waited for, if not for long: no dry run takes the time of a job.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import structlog
from distributed.scheduler import KilledWorker
from pydantic import BaseModel

from woodcock.device import Device, DeviceError
from woodcock.formats import VolumeError
from woodcock.image import ImageError
from woodcock.predict import Memory
from woodcock.scene import SceneError, Stop, files, with_files
from woodcock_server import worker
from woodcock_server.devices.choice import leaves_a_choice, meant
from woodcock_server.devices.service import Found
from woodcock_server.identifiers import new_id
from woodcock_server.jobs.requests import RequestCheck
from woodcock_server.jobs.schemas import JobCreate
from woodcock_server.services import Services
from woodcock_server.storage import StoreAway
from woodcock_server.threads import in_thread
from woodcock_server.worker import Survey

log = structlog.get_logger()

#: A device that renders is waited for so long, seconds.
PATIENCE = 3.0
#: A dry run is answered within so many seconds, whatever is known by then.
LIMIT = 20.0

DISTRUSTED = "It failed its newest stability check, and renders only jobs that ask for it by its id."


class ProgramForecast(BaseModel):
    """What would be compiled, on the first device that could tell: vector widths differ, and with them texts.

    hash: of the text, hex; kinds: by concept; lanes: paths in lockstep; source_lines: without comments; built: was it
    compiled on this device before? remained, left_out: lines of each file of device code that is in it, and that is
    not.
    """

    hash: str
    kinds: dict[str, list[str]]
    lanes: int
    source_lines: int
    built: bool
    remained: dict[str, int]
    left_out: dict[str, int]


class MemoryForecast(BaseModel):
    """Bytes. device: of all buffers; largest: of one of them; host: of pictures while they are merged."""

    device: int
    largest: int
    host: int


class DeviceForecast(BaseModel):
    """A render by this device alone. fits: can it render the scene? null: not known; reason: why not.

    read_seconds, build_seconds: taken now, of reading the files and of building the program, which is kept for the job.
    seconds: of rendering until the contract is met, in [low, high] with 95 % confidence; high is null where it has no
    bound. samples: per pixel; error: estimated at the end, relative to the mean luminance. What is not known is null,
    and `says` tells why.
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


class JobCheck(BaseModel):
    """A dry run. contract: when the render would stop; program, memory: null where no device was free to tell."""

    contract: Stop
    program: ProgramForecast | None
    memory: MemoryForecast | None
    devices: list[DeviceForecast]


async def check(services: Services, request: JobCreate) -> JobCheck:
    """Raises InvalidRequest as submitting does."""
    await in_thread(RequestCheck(services).check, request)
    with ExitStack() as held:
        where = await in_thread(held.enter_context, services.cluster.files(files(request.scene)))
        text = with_files(request.scene, lambda file: str(where[file])).model_dump_json()
        return await _checked(services, request, text)


async def _checked(services: Services, request: JobCreate, text: str) -> JobCheck:
    """text: the scene as workers read it."""
    asked = meant(request.device, services.devices)
    distrusted = await in_thread(_distrusted, services) if leaves_a_choice(request.device) else set()
    run = _DryRun(services, text)
    able = [device for device in asked if device.ready and device.id not in distrusted]
    surveys = dict(zip([each.id for each in able], await asyncio.gather(*map(run.survey, able)), strict=True))
    known = next((each for each in surveys.values() if isinstance(each, Survey)), None)
    forecasts = []
    for device in asked:
        if not device.ready:
            forecasts.append(DeviceForecast(id=device.id, fits=False, reason=device.probe.fault))
        elif device.id in distrusted:
            forecasts.append(_fitting(device, known, DISTRUSTED))
        else:  # One after the other: devices may share a processor, and each is told as if it were alone.
            forecasts.append(await run.measure(device, surveys[device.id], known))
    return JobCheck(
        contract=request.scene.stop,
        program=known and ProgramForecast.model_validate(known.program),
        memory=known and MemoryForecast.model_validate(known.memory),
        devices=forecasts,
    )


def _distrusted(services: Services) -> set[str]:
    with services.engine.connect() as connection:
        return services.checks.distrusted(connection)


class _DryRun:
    def __init__(self, services: Services, text: str) -> None:
        self._services, self._text = services, text
        self._end = time.monotonic() + LIMIT

    async def survey(self, device: Found) -> Survey | DeviceForecast:
        """What a device would compile and hold, or why that is not known."""
        if device.id in self._services.checks.under_way:
            return DeviceForecast(id=device.id, says="Its stability check is under way; ask again when that has ended.")
        if not await self._services.checks.left(device.id, PATIENCE):
            return DeviceForecast(id=device.id, says="It renders a job; ask again when that has ended.")
        found: Survey | DeviceForecast = await self._ask(device, worker.survey)
        return found

    async def measure(self, device: Found, survey: Survey | DeviceForecast, known: Survey | None) -> DeviceForecast:
        if isinstance(survey, DeviceForecast):
            return survey if survey.fits is False else _fitting(device, known, survey.says)
        forecast = _fitting(device, survey, "")
        if not forecast.fits:
            return forecast
        # A job may have come in the meantime.
        if not await self._services.checks.left(device.id, PATIENCE):
            return _fitting(device, survey, "It renders a job by now; ask again when that has ended.")
        found = await self._ask(device, worker.forecast)
        if isinstance(found, DeviceForecast):
            return found if found.fits is False else _fitting(device, survey, found.says)
        build_seconds, prediction = found
        told = {"read_seconds": survey.read_seconds, "build_seconds": build_seconds, **prediction}
        return forecast.model_copy(update=told)

    async def _ask(self, device: Found, function: Callable[..., Any]) -> Any:
        """What a function of the worker says; a forecast of why it does not."""
        key, left = f"check-{new_id()}", self._end - time.monotonic()
        late = f"It was not done within {LIMIT:g} s; what was built is kept, so ask again."
        if left <= 0:
            return DeviceForecast(id=device.id, says=late)
        try:
            return await asyncio.wait_for(
                self._services.cluster.ask(device.id, key, function, self._text, device.id), left
            )
        except TimeoutError:
            return DeviceForecast(id=device.id, says=late)
        except KilledWorker as error:
            reason = f"The process that renders on {device.id} died {error.allowed_failures + 1} times."
        except (SceneError, VolumeError, ImageError, DeviceError) as error:
            reason = self._services.storage.by_id(str(error))
        except StoreAway as error:
            return DeviceForecast(id=device.id, says=str(error))
        except Exception as error:
            log.exception("dry run broke off", device=device.id)
            return DeviceForecast(id=device.id, says=f"It could not be tried: {error}")
        return DeviceForecast(id=device.id, fits=False, reason=reason)


def _fitting(device: Found, survey: Survey | None, says: str) -> DeviceForecast:
    """By what another device, perhaps, found out of the scene."""
    if survey is None:
        return DeviceForecast(id=device.id, says=says)
    reason = too_large(survey.memory, device.device)
    return DeviceForecast(id=device.id, fits=reason is None, reason=reason, says=says)


def too_large(memory: Memory, device: Device) -> str | None:
    """Why a scene does not fit into a device's memory."""
    limits = (("in one piece", memory["largest"], device.max_allocation), ("in all", memory["device"], device.memory))
    for what, needed, there_is in limits:
        if needed > there_is:
            return f"It has {there_is >> 20} MiB of memory {what}; the scene needs {-(-needed >> 20)} MiB."
    return None
