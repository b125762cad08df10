"""/api/v1/volumes"""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, Response
from sqlalchemy import RowMapping

from woodcock_server.access.guard import Owner
from woodcock_server.names import ONE_LINE
from woodcock_server.paging import Cursor, Limit, link_next
from woodcock_server.problems import Fault, InvalidRequest, problem_schema
from woodcock_server.services import Provided
from woodcock_server.volumes import repository, service
from woodcock_server.volumes.samples import Axis, Samples, cut, png
from woodcock_server.volumes.schemas import GridRange, Volume, VolumePage, volume

router = APIRouter(prefix="/api/v1/volumes", tags=["volumes"])

#: The id is that of the content: what it names never changes.
FOR_EVER = {"Cache-Control": "private, max-age=31536000, immutable"}

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


def _existing(id: str, services: Provided) -> RowMapping:
    return service.existing(services.engine, id)


Existing = Annotated[RowMapping, Depends(_existing)]


@router.get("/{id}", responses=problem_schema(404))
def get_volume(row: Existing) -> Volume:
    """One uploaded file."""
    return volume(row)


async def _looked(
    row: Existing,
    services: Provided,
    grid: Annotated[
        str | None,
        Query(max_length=1000, description="Its name; by default `density`, or the only one there is."),
    ] = None,
) -> tuple[str, Samples]:
    return await service.look(services, row, grid)


Looked = Annotated[tuple[str, Samples], Depends(_looked)]


@router.get("/{id}/range", responses=problem_schema(404))
def get_range(looked: Looked, response: Response) -> GridRange:
    """Between which values a grid is, and how its slices show it."""
    name, samples = looked
    response.headers.update(FOR_EVER)
    return GridRange(name=name, **samples.model_dump(exclude={"values"}))


@router.get("/{id}/slice.png", response_class=Response, responses=problem_schema(404))
def get_slice(
    looked: Looked,
    axis: Annotated[Axis, Query(description="That the slice is across.")] = "z",
    position: Annotated[
        int | None, Query(ge=0, description="Along the axis, in voxels from 0 on; by default the middle.")
    ] = None,
) -> Response:
    """A slice of a grid: black for 0 and less, white for its largest value, linear in between; grids of vectors in
    colour. Up is y in slices across z, else z; to the right is x, or y in slices across x.
    """
    name, samples = looked
    end = samples.shape["xyz".index(axis)]
    at = end // 2 if position is None else position
    if at >= end:
        fault = Fault(field="position", message=f"must be less than {end}, the voxels along {axis}")
        raise InvalidRequest(f"{name} ends before that.", fault)
    return Response(png(cut(samples, axis, at)), media_type="image/png", headers=FOR_EVER)
