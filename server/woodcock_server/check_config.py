"""`woodcock serve --check-config`: would the service start with these settings, and with what? Nothing is changed."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from sqlalchemy import make_url
from sqlalchemy.exc import SQLAlchemyError

from woodcock_server import certificate
from woodcock_server.access import tokens
from woodcock_server.access.guard import Exposed, is_loopback
from woodcock_server.config import Settings
from woodcock_server.database import connect, revision
from woodcock_server.devices.service import Found, discover
from woodcock_server.farm.remote import look
from woodcock_server.storage import PROBE, NoStore, StoreAway, open_store
from woodcock_server.usable import reason


class Fault(str):
    """A sentence that says why the service would not start."""


def check(settings: Settings) -> Iterator[str]:
    """Sentences, those that are a Fault among them, as they are found."""
    yield _folder(settings.data)
    yield from _database(settings)
    if settings.store is not None:
        yield _store(settings.store)
    if settings.scheduler is None:
        yield from map(_device, discover())
    else:
        yield from _farm(settings.scheduler, settings.certificates)


def _device(device: Found) -> str:
    if not device.ready:
        return Fault(f"Device {device.id} cannot be used: {device.probe.fault}")
    lanes = ", ".join(map(str, device.probe.lanes))
    return f"Device {device.id} is ready: {device.device.name}, {device.device.platform}, lanes {lanes}."


def _farm(scheduler: str, certificates: Path | None) -> Iterator[str]:
    try:
        devices = asyncio.run(look(scheduler, certificate.of(certificates)))
    except certificate.CertificateError as error:
        yield Fault(str(error))
    except OSError as error:
        yield Fault(f"The scheduler at {scheduler} cannot be reached with these certificates: {_cause(error)}.")
    else:
        yield f"The scheduler at {scheduler} answers{'' if devices else ', but has no worker with a device'}."
        yield from (_device(devices[device_id]) for device_id in sorted(devices))


def _cause(error: BaseException) -> str:
    """What Dask's own sentence, which is of its calls, comes from."""
    deeper = error.__cause__ and _cause(error.__cause__)
    return deeper or str(error)


def _folder(folder: Path) -> str:
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not there.is_dir():
        return Fault(f"The data folder {folder} cannot be used: {there} is no folder.")
    if not os.access(there, os.W_OK | os.X_OK):
        return Fault(f"The data folder {folder} cannot be used: {there} cannot be written.")
    return f"The data folder is {folder}{'' if folder.exists() else ', which will be made'}."


def _store(url: str) -> str:
    try:
        open_store(url).size(PROBE)
    except (NoStore, StoreAway) as error:
        return Fault(str(error))
    return f"The object store is {url}."


def _database(settings: Settings) -> Iterator[str]:
    """And whether it keeps strangers out."""
    url, guarded = make_url(settings.database), settings.insecure or is_loopback(settings.host)
    if url.get_backend_name() == "sqlite" and not Path(url.database or "").exists():
        yield f"The database is {url!r}, which will be made."
    else:
        try:
            engine = connect(settings.database)
            with engine.connect() as connection:
                state = revision(connection)
                guarded = guarded or (state.current and tokens.usable(connection, datetime.now(UTC)))
            engine.dispose()
        except SQLAlchemyError as error:
            yield Fault(f"The database {url!r} cannot be used: {reason(error)}.")
            return
        yield f"The database is {url!r}, revision {state.found or 'none'}" + (
            "." if state.current else f", to be brought to {state.head}."
        )
    if not guarded:
        yield Fault(str(Exposed(settings.host)))
