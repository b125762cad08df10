"""Taking files in: stored under the hash of their content, once they are known to be readable."""

from __future__ import annotations

from collections.abc import AsyncIterator

from anyio import to_thread
from sqlalchemy import Engine, RowMapping
from sqlalchemy.exc import IntegrityError

from woodcock_server.problems import Fault, InvalidRequest
from woodcock_server.storage import Storage, Upload
from woodcock_server.volumes import contents, repository


async def receive(engine: Engine, storage: Storage, name: str, chunks: AsyncIterator[bytes]) -> tuple[RowMapping, bool]:
    """Store a file; returns its row and whether it is new.

    Raises InvalidRequest for a file that cannot be read; nothing stays of it.
    """
    with storage.upload() as upload:
        async for chunk in chunks:
            await to_thread.run_sync(upload.write, chunk)
        return await to_thread.run_sync(_keep, engine, storage, upload, name)


def _keep(engine: Engine, storage: Storage, upload: Upload, name: str) -> tuple[RowMapping, bool]:
    volume_id = f"sha256:{upload.finish()}"
    with engine.connect() as connection:
        known = repository.get(connection, volume_id)
    if known is not None and storage.volume_file(volume_id).exists():
        return known, False
    try:
        found = contents.read(upload.path)
    except contents.UnreadableFile as error:
        raise InvalidRequest(f"{name}: {error}", Fault(field="body", message=str(error))) from None
    storage.keep_volume(upload.path, volume_id)
    new = True
    try:
        with engine.begin() as connection:
            repository.add(connection, volume_id, name, upload.size, found)
    except IntegrityError:  # The same bytes came in twice at once, or their file had gone.
        new = False
    with engine.connect() as connection:
        row = repository.get(connection, volume_id)
    assert row is not None, "volumes are never deleted"
    return row, new
