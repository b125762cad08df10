"""What a job's picture is held against: the picture of another job, or one that was uploaded."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from sqlalchemy import Connection, Engine

from woodcock.image import ImageError
from woodcock.reference import Reference
from woodcock.scene import UPLOADED
from woodcock_server.jobs import repository
from woodcock_server.jobs.states import State
from woodcock_server.storage import Storage
from woodcock_server.volumes import repository as volumes
from woodcock_server.volumes.check import FILE_ID


def load(storage: Storage, reference: str) -> Reference:
    """The picture that a job names. Raises ImageError."""
    return replace(Reference.load(_path(storage, reference)), name=reference)


def fault(engine: Engine, storage: Storage, reference: str, width: int, height: int) -> str | None:
    """Why no picture of that size can be held against it."""
    with engine.connect() as connection:
        message = _fault(connection, reference, width, height)
    if message is None:
        try:
            load(storage, reference)
        except ImageError as error:
            message = storage.by_id(str(error))
    return message


def _fault(connection: Connection, reference: str, width: int, height: int) -> str | None:
    """What the database knows to be wrong."""
    if FILE_ID.fullmatch(reference):
        file = volumes.get(connection, reference)
        if file is None:
            return "must be the id (sha256:…) of a picture that was uploaded to /api/v1/volumes"
        if file["type"] != "picture":
            return f"must be a picture; {file['name']} is a {file['type']}"
        size = file["width"], file["height"]
    else:
        row = repository.get(connection, reference)
        if row is None:
            return "must be the id of a job that has succeeded, or that of an uploaded picture (sha256:…)"
        if row["state"] != State.SUCCEEDED:
            return f"must be a job that has succeeded; {reference} is {row['state']}"
        size = row["scene"]["film"]["width"], row["scene"]["film"]["height"]
    if size != (width, height):
        return f"must be {width} × {height} pixels, as the scene's film is; it is {size[0]} × {size[1]}"
    return None


def _path(storage: Storage, reference: str) -> Path:
    if reference.startswith(UPLOADED):
        return storage.volume_file(reference)
    return storage.job_file(reference, "image.exr")
