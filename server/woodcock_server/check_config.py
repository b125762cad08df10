"""`woodcock serve --check-config`: would the service start with these settings, and with what? Nothing is changed."""

from __future__ import annotations

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
from woodcock_server.devices.service import discover
from woodcock_server.usable import reason


class Fault(str):
    """A sentence that says why the service would not start."""


def check(settings: Settings) -> Iterator[str]:
    """Sentences, those that are a Fault among them, as they are found."""
    yield _folder(settings.data)
    yield from _database(settings)
    if settings.scheduler is not None:
        yield _certificate(settings)
        return
    for device in discover():
        if device.ready:
            lanes = ", ".join(map(str, device.probe.lanes))
            yield f"Device {device.id} is ready: {device.device.name}, {device.device.platform}, lanes {lanes}."
        else:
            yield Fault(f"Device {device.id} cannot be used: {device.probe.fault}")


def _certificate(settings: Settings) -> str:
    try:
        certificate.of(settings.certificates)
    except certificate.CertificateError as error:
        return Fault(str(error))
    return f"Devices are those of the workers that the scheduler at {settings.scheduler} has."


def _folder(folder: Path) -> str:
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not there.is_dir():
        return Fault(f"The data folder {folder} cannot be used: {there} is no folder.")
    if not os.access(there, os.W_OK | os.X_OK):
        return Fault(f"The data folder {folder} cannot be used: {there} cannot be written.")
    return f"The data folder is {folder}{'' if folder.exists() else ', which will be made'}."


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
