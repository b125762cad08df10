"""Taking files in: stored under the hash of their content, once they are known to be readable."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from anyio import to_thread
from fastapi import HTTPException
from sqlalchemy import Engine, RowMapping
from sqlalchemy.exc import IntegrityError

from woodcock.formats import VolumeError
from woodcock.formats.grid import choose
from woodcock_server.problems import Fault, InvalidRequest
from woodcock_server.services import Services
from woodcock_server.storage import Collected, Upload
from woodcock_server.volumes import repository
from woodcock_server.volumes.contents import UnreadableFile
from woodcock_server.volumes.samples import Samples


async def receive(services: Services, owner: str, name: str, chunks: AsyncIterator[bytes]) -> tuple[RowMapping, bool]:
    """Store a file; returns its row and whether it is new.

    Raises InvalidRequest for a file that cannot be read, TooMuch for more than the owner may keep; nothing stays of it.
    """
    await to_thread.run_sync(_admit, services, owner, 0)
    with services.storage.upload() as upload:
        async for chunk in chunks:
            await to_thread.run_sync(upload.write, chunk)
        return await to_thread.run_sync(_keep, services, owner, upload, name, limiter=services.parser.turns)


def _admit(services: Services, owner: str, size: int) -> None:
    with services.engine.connect() as connection:
        services.limits.check_room(connection, owner, size)


def _keep(services: Services, owner: str, upload: Upload, name: str) -> tuple[RowMapping, bool]:
    volume_id, path = f"sha256:{upload.finish()}", upload.path
    if not (_used_again(services, volume_id) and services.storage.has_volume(volume_id)):
        _admit(services, owner, upload.size)
        try:
            found = services.parser.read(path)
        except UnreadableFile as error:
            raise InvalidRequest(f"{name}: {error}", Fault(field="body", message=str(error))) from None
        columns = {"owner": owner, "name": name, "size": upload.size, **found.model_dump(mode="json")}
        new = _stored(services, path, volume_id, columns)
    else:
        new = False
    with services.engine.connect() as connection:
        row = repository.get(connection, volume_id)
    assert row is not None, "what was used just now is not collected"
    return row, new


def _stored(services: Services, path: Path, volume_id: str, columns: dict[str, Any]) -> bool:
    """Bring a file to its place, and its row with it; is that new?"""
    while True:
        try:
            # The row first: as long as it is being written nobody collects the file.
            with (
                services.storage.bringing_volume(path, volume_id) as keep,
                services.engine.begin() as connection,
            ):
                new = not repository.use(connection, volume_id)
                if new:
                    repository.add(connection, volume_id, columns)
                keep()
            return new
        except (IntegrityError, Collected):  # The same bytes came in twice at once, or went as they came.
            continue


def _used_again(services: Services, volume_id: str) -> bool:
    """The row is there, and stays for as long as what is new does."""
    with services.engine.begin() as connection:
        return repository.use(connection, volume_id)


def existing(engine: Engine, volume_id: str) -> RowMapping:
    """Raises HTTPException 404."""
    with engine.connect() as connection:
        row = repository.get(connection, volume_id)
    if row is None:
        raise HTTPException(404, f"There is no volume {volume_id}.")
    return row


async def look(services: Services, row: RowMapping, grid: str | None) -> tuple[str, Samples]:
    """The name of the grid that is meant, and what it looks like. Raises InvalidRequest."""
    if row["type"] != "volume":
        raise InvalidRequest("Only volumes have slices.", Fault(field="id", message=f"is a {row['type']}"))
    names = [each["name"] for each in row["grids"]]
    try:
        position = choose(names, grid)
        return names[position], await services.slices.samples(row["id"], position)
    except (VolumeError, UnreadableFile) as error:
        raise InvalidRequest(f"{row['name']}: {error}", Fault(field="grid", message=str(error))) from None
