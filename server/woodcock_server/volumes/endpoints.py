"""/api/v1/volumes"""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, HTTPException, Query, Request, Response

from woodcock_server.access.guard import Owner
from woodcock_server.names import ONE_LINE
from woodcock_server.paging import Cursor, Limit, link_next
from woodcock_server.problems import problem_schema
from woodcock_server.services import Provided
from woodcock_server.volumes import repository, service
from woodcock_server.volumes.schemas import Volume, VolumePage, volume

router = APIRouter(prefix="/api/v1/volumes", tags=["volumes"])

_BODY = {"required": True, "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}}}


@router.post(
    "",
    status_code=201,
    responses={200: {"model": Volume, "description": "It was there."}, **problem_schema(413, 429)},
    openapi_extra={"requestBody": _BODY},
)
async def upload_volume(
    request: Request,
    response: Response,
    services: Provided,
    owner: Owner,
    name: Annotated[str, Query(min_length=1, max_length=200, description="File name to show."), ONE_LINE],
) -> Volume:
    """Upload a file that scenes may name, as the request's body: a volume, a mesh or a picture, told apart by their
    content. The same content is stored once.
    """
    row, new = await service.receive(services, owner, name, request.stream())
    response.status_code = 201 if new else 200
    response.headers["Location"] = f"{router.prefix}/{row['id']}"
    return volume(row)


@router.get("")
def list_volumes(
    request: Request, response: Response, services: Provided, limit: Limit = 50, cursor: Cursor = None
) -> VolumePage:
    """Uploaded files, newest first."""
    with services.engine.connect() as connection:
        rows, following = repository.page(connection, limit, cursor)
    link_next(request, response, following)
    return VolumePage(items=[volume(row) for row in rows], next=following)


@router.get("/{id}", responses=problem_schema(404))
def get_volume(id: str, services: Provided) -> Volume:
    """One uploaded file."""
    with services.engine.connect() as connection:
        row = repository.get(connection, id)
    if row is None:
        raise HTTPException(404, f"There is no volume {id}.")
    return volume(row)
