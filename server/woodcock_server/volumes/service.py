"""Taking volumes in: stored under the hash of their content, once they are known to be readable."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator
from dataclasses import asdict
from typing import Any

from anyio import to_thread
from sqlalchemy import Engine, RowMapping
from sqlalchemy.exc import IntegrityError

from woodcock.formats import GridInfo, VolumeError, list_grids
from woodcock.formats.grid import choose
from woodcock.scene import GridVolume, Scene
from woodcock.volume.grid import check_info
from woodcock_server.problems import Fault, InvalidRequest
from woodcock_server.storage import Storage, Upload
from woodcock_server.volumes import repository

VOLUME_ID = re.compile(r"sha256:[0-9a-f]{64}")


async def receive(engine: Engine, storage: Storage, name: str, chunks: AsyncIterator[bytes]) -> tuple[RowMapping, bool]:
    """Store a volume; returns its row and whether it is new.

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
    grids = _grids(upload, name)
    storage.keep_volume(upload.path, volume_id)
    new = True
    try:
        with engine.begin() as connection:
            repository.add(connection, volume_id, name, upload.size, grids)
    except IntegrityError:  # The same bytes came in twice at once, or their file had gone.
        new = False
    with engine.connect() as connection:
        row = repository.get(connection, volume_id)
    assert row is not None, "volumes are never deleted"
    return row, new


def _grids(upload: Upload, name: str) -> list[dict[str, Any]]:
    try:
        if grids := list_grids(upload.path):
            return [asdict(grid) for grid in grids]
        message = "holds no grid"
    except VolumeError as error:
        # The reader names the temporary file, of which the sender knows nothing.
        message = str(error).removeprefix(f"{upload.path}: ")
    raise InvalidRequest(f"{name}: {message}", Fault(field="body", message=message))


def check_scene(engine: Engine, scene: Scene) -> None:
    """Raises InvalidRequest that names each volume of a scene that was not uploaded or lacks a density to render."""
    faults = []
    with engine.connect() as connection:
        for position, volume in enumerate(scene.volumes):
            if isinstance(volume, GridVolume):
                where = f"scene.volumes[{position}]"
                row = repository.get(connection, volume.file) if VOLUME_ID.fullmatch(volume.file) else None
                if row is None:
                    message = "must be the id (sha256:…) of a volume that was uploaded to /api/v1/volumes"
                    faults.append(Fault(field=f"{where}.file", message=message))
                    continue
                grids = [GridInfo(**grid) for grid in row["grids"]]
                try:
                    check_info(grids[choose([grid.name for grid in grids], volume.grid)])
                except VolumeError as error:
                    faults.append(Fault(field=f"{where}.grid", message=f"{row['name']} {error}"))
    if faults:
        raise InvalidRequest("The scene names volumes that cannot be rendered.", *faults)
