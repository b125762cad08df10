"""/api/v1/batches"""

from __future__ import annotations

from typing import Annotated

from anyio import to_thread
from fastapi import APIRouter, Depends, Request, Response

from woodcock_server.access.guard import Owner
from woodcock_server.batches import service
from woodcock_server.batches.schemas import PREFIX, Batch, BatchCreate, BatchPage
from woodcock_server.etags import UNCHANGED, tagged
from woodcock_server.idempotency import Key
from woodcock_server.jobs.repository import Row
from woodcock_server.paging import Cursor, Limit, link_next
from woodcock_server.problems import problem_schema
from woodcock_server.services import Provided

router = APIRouter(prefix=PREFIX, tags=["batches"])


def _existing(id: str, services: Provided) -> Row:
    with services.engine.connect() as connection:
        return service.existing(connection, id)


Existing = Annotated[Row, Depends(_existing)]


@router.post("", status_code=201, responses=problem_schema(413, 429))
async def sweep_scene(
    request: BatchCreate, response: Response, services: Provided, owner: Owner, key: Key = None
) -> Batch:
    """Queue a job for each combination of values of a scene's fields; they are in the database before this answers, all
    or none."""
    made = await to_thread.run_sync(service.create, services, request, owner, key)
    services.dispatcher.wake()
    response.headers["Location"] = made.links.self
    return made


@router.get("", response_model=BatchPage, responses=UNCHANGED)
def list_batches(
    request: Request, response: Response, services: Provided, limit: Limit = 50, cursor: Cursor = None
) -> Response:
    """Batches without their jobs, newest first."""
    with services.engine.connect() as connection:
        items, following = service.listed(connection, limit, cursor)
    link_next(request, response, following)
    return tagged(request, response, BatchPage(items=items, next=following))


@router.get("/{id}", response_model=Batch, responses={**UNCHANGED, **problem_schema(404)})
def get_batch(row: Existing, request: Request, response: Response, services: Provided) -> Response:
    """One batch: what is swept, and how far each of its jobs is."""
    with services.engine.connect() as connection:
        shown = service.shown(connection, services, row)
    return tagged(request, response, shown)


@router.post("/{id}/cancel", status_code=202, responses=problem_schema(404, 409))
async def cancel_batch(row: Existing, services: Provided) -> Batch:
    """Stop every job of a batch that has not ended, as cancelling each would."""
    shown, cancelled = await to_thread.run_sync(service.cancel, services, row)
    services.dispatcher.look()
    for job_id in cancelled:
        services.changes.publish(job_id)
    return shown


@router.delete("/{id}", status_code=204, responses=problem_schema(404, 409))
def delete_batch(row: Existing, services: Provided) -> None:
    """Forget a batch whose jobs have all ended, with them and their pictures."""
    service.delete(services, row)
