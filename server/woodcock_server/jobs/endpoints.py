"""/api/v1/jobs"""

from __future__ import annotations

import html
import re
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Annotated, Any

from anyio import to_thread
from fastapi import APIRouter, Depends, Header, HTTPException, Query, Request, Response
from fastapi.responses import FileResponse, HTMLResponse, RedirectResponse
from fastapi.sse import EventSourceResponse, ServerSentEvent
from pydantic import AwareDatetime, BeforeValidator

from woodcock.report_schema import Report
from woodcock_server.access.guard import Owner
from woodcock_server.etags import UNCHANGED, tagged
from woodcock_server.idempotency import Key
from woodcock_server.jobs import listing, repository, service
from woodcock_server.jobs.check import JobCheck, check
from woodcock_server.jobs.schemas import (
    PREFIX,
    Job,
    JobChange,
    JobCounts,
    JobCreate,
    JobExtension,
    JobPage,
    JobsDeleted,
    JobsToDelete,
    Tag,
    summary,
)
from woodcock_server.jobs.states import State
from woodcock_server.names import ONE_LINE
from woodcock_server.paging import Cursor, Limit, link_next
from woodcock_server.problems import problem_schema
from woodcock_server.services import Provided, Services
from woodcock_server.tables import job_devices, job_tags, jobs

router = APIRouter(prefix=PREFIX, tags=["jobs"])

#: By which a report's page says itself what may load and run in it.
POLICY = re.compile(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">')
NOTHING = "default-src 'none'"


def _written(time: Any) -> Any:
    """Numbers would count as seconds or milliseconds, by their size."""
    if isinstance(time, str) and "-" not in time.strip("-"):
        raise ValueError("must be a time, such as 2030-01-02T03:04:05Z")
    return time


Time = Annotated[AwareDatetime, BeforeValidator(_written)]


def _existing(id: str, services: Provided) -> repository.Row:
    with services.engine.connect() as connection:
        return service.existing(connection, id)


Existing = Annotated[repository.Row, Depends(_existing)]


@router.post("", status_code=201, responses=problem_schema(413, 429))
async def submit_job(request: JobCreate, response: Response, services: Provided, owner: Owner, key: Key = None) -> Job:
    """Queue a render; it is in the database before this answers."""
    return _queued(await to_thread.run_sync(service.create, services, request, owner, key), response, services)


def _queued(made: Job, response: Response, services: Services) -> Job:
    services.dispatcher.wake()
    response.headers["Location"] = made.links.self
    return made


@router.post("/check", responses=problem_schema(413))
async def check_job(request: JobCreate, services: Provided) -> JobCheck:
    """Try a job without queuing it: what would be compiled, which devices it fits, and how long it would render.

    Takes some seconds, for a part of the picture is rendered. A device that renders a job is not disturbed.
    """
    return await check(services, request)


@router.post("/validate", status_code=204, responses=problem_schema(413, 429))
def validate_job(request: JobCreate, services: Provided, owner: Owner) -> None:
    """Would it be taken? Refuses what submitting refuses, with the same faults; nothing is queued or tried."""
    service.validate(services, request, owner)


@router.get("", response_model=JobPage, responses=UNCHANGED)
def list_jobs(
    request: Request,
    response: Response,
    services: Provided,
    limit: Limit = 50,
    cursor: Cursor = None,
    state: Annotated[list[State] | None, Query(description="Jobs in this state; several may be given.")] = None,
    tag: Annotated[list[Tag] | None, Query(max_length=20, description="With this tag; of several, with all.")] = None,
    owner: Annotated[str | None, Query(max_length=200, description="Of this owner."), ONE_LINE] = None,
    text: Annotated[
        str | None, Query(max_length=200, description="A part of the name, in letters of any case."), ONE_LINE
    ] = None,
    since: Annotated[Time | None, Query(description="Created then or later.")] = None,
    before: Annotated[Time | None, Query(description="Created earlier.")] = None,
    batch: Annotated[str | None, Query(max_length=36, description="Of this batch."), ONE_LINE] = None,
    device: Annotated[str | None, Query(max_length=64, description="That this device rendered."), ONE_LINE] = None,
    integrator: Annotated[str | None, Query(max_length=64, description="By this integrator."), ONE_LINE] = None,
) -> Response:
    """Jobs without their scenes, newest first."""
    meant = listing.Filter(state or (), tag or (), owner, text, since, before, batch, device, integrator)
    with services.engine.connect() as connection:
        rows, following = listing.page(connection, limit, cursor, meant)
        waiting = service.waiting(connection, services.dispatcher, rows)
    link_next(request, response, following)
    page = JobPage(items=[summary(*each) for each in zip(rows, waiting, strict=True)], next=following)
    return tagged(request, response, page)


@router.get("/counts")
def count_jobs(services: Provided) -> JobCounts:
    """How many jobs there are of each sort by which they can be found."""
    with services.engine.connect() as connection:
        return JobCounts(
            states=listing.states(connection),
            tags=listing.counted(connection, job_tags.c.tag),
            devices=listing.counted(connection, job_devices.c.device),
            integrators=listing.counted(connection, jobs.c.integrator),
        )


@router.get("/{id}", responses=problem_schema(404))
def get_job(row: Existing, services: Provided) -> Job:
    """One job, with its scene."""
    with services.engine.connect() as connection:
        return service.described(connection, services.dispatcher, row)


@router.patch("/{id}", responses=problem_schema(404))
async def change_job(id: str, request: JobChange, services: Provided) -> Job:
    """Change its name, tags or priority."""
    changed = await to_thread.run_sync(service.change, services, id, request)
    services.changes.publish(id)
    return changed


@router.delete("/{id}", status_code=204, responses=problem_schema(404, 409))
def delete_job(row: Existing, services: Provided) -> None:
    """Forget a job that has ended, and its pictures."""
    service.delete(services, row)


@router.post("/delete")
def delete_jobs(asked: JobsToDelete, services: Provided) -> JobsDeleted:
    """Forget those of some jobs that have ended, and their pictures; each alone, as `DELETE` would."""
    return service.delete_all(services, asked.ids)


@router.post("/{id}/cancel", status_code=202, responses=problem_schema(404, 409))
async def cancel_job(id: str, services: Provided) -> Job:
    """Stop a job that has not ended: at once, or, while it is rendered, as soon as whoever renders it lets go of it."""
    cancelled = await to_thread.run_sync(service.cancel, services, id)
    services.dispatcher.look()
    services.changes.publish(id)
    return cancelled


@router.post("/{id}/retry", status_code=201, responses=problem_schema(404, 409, 429))
async def retry_job(id: str, response: Response, services: Provided, owner: Owner, key: Key = None) -> Job:
    """Queue a new job that asks for the same as one that failed or was cancelled."""
    return _queued(await to_thread.run_sync(service.retry, services, id, owner, key), response, services)


@router.post("/{id}/extend", status_code=201, responses=problem_schema(404, 409, 429))
async def extend_job(
    id: str, asked: JobExtension, response: Response, services: Provided, owner: Owner, key: Key = None
) -> Job:
    """Queue a new job that goes on from the samples of one that has succeeded, to a stricter contract."""
    return _queued(await to_thread.run_sync(service.extend, services, id, asked, owner, key), response, services)


@router.get("/{id}/events", response_class=EventSourceResponse, responses=problem_schema(404))
async def follow_job(
    row: Existing,
    services: Provided,
    last: Annotated[
        str | None, Header(alias="Last-Event-ID", description="Of the last event that came: those after it come again.")
    ] = None,
) -> AsyncIterator[ServerSentEvent]:
    """The job, as server-sent events: every state that it came to (`state`, with an id), and after these as it is now,
    at each change (`progress`) and at its end (`end`)."""
    after = int(last) if last is not None and last.isdecimal() and len(last) < 16 else 0
    async for now in service.follow(services.engine, services.changes, services.dispatcher, row["id"], after):
        if isinstance(now, tuple):
            yield ServerSentEvent(event="state", id=str(now[0]), data=now[1])
        else:
            yield ServerSentEvent(event="end" if now.state.final else "progress", data=now)


# Results


@router.get("/{id}/image.exr", response_class=FileResponse, responses=problem_schema(404))
def get_image(row: Existing, services: Provided) -> FileResponse:
    """The picture, an EXR: beauty, the layers that the scene asks for, variance and sample count."""
    path = _result(row, services, "image.exr", summary(row).links.image)
    return FileResponse(path, media_type="image/x-exr")


Samples = Annotated[int | None, Query(ge=0, description="Of the job, as the client knows it; with the state.")]
#: Answers of a version that will never be another one, and of the picture as it is now.
FOR_EVER, FOR_NOW = "private, max-age=31536000, immutable", "no-cache"


@router.get("/{id}/preview.png", response_class=Response, responses=problem_schema(404))
def get_preview(row: Existing, services: Provided, samples: Samples = None, state: State | None = None) -> Response:
    """The picture so far, tone-mapped.

    Kept by browsers for ever where the address says as of which samples and state it is, and the job has ended so.
    """
    path = _result(row, services, "preview.png", summary(row).links.preview)
    return _picture(path, "image/png", row, samples, state)


@router.get(
    "/{id}/thumbnail.webp",
    response_class=Response,
    responses={307: {"description": "To the preview: the job is of a version that wrote none."}, **problem_schema(404)},
)
def get_thumbnail(row: Existing, services: Provided, samples: Samples = None, state: State | None = None) -> Response:
    """The preview, at most 320 pixels wide and high; kept as long as that is."""
    links = summary(row).links
    path = services.storage.job_file(row["id"], "thumbnail.webp")
    if links.preview is not None and not path.is_file():
        return RedirectResponse(links.preview, headers={"Cache-Control": FOR_NOW})
    return _picture(_result(row, services, "thumbnail.webp", links.thumbnail), "image/webp", row, samples, state)


def _picture(path: Path, kind: str, row: repository.Row, samples: int | None, state: State | None) -> Response:
    """samples, state: of the version that the address names."""
    # The last samples are counted before the last picture is there, so they alone do not name it; and what is replaced
    # now may be newer than the row that was read. After the end nothing is.
    named = State(row["state"]).final and (samples, state) == (row["samples"], row["state"])
    try:
        # Read at once: a file that is replaced while it is sent would not have the length that was announced.
        content = path.read_bytes()
    except FileNotFoundError:  # It was deleted just now, as from a wall that shows it.
        raise service.JobMissing(row["id"]) from None
    return Response(content, media_type=kind, headers={"Cache-Control": FOR_EVER if named else FOR_NOW})


@router.get("/{id}/report.json", response_model=Report, responses=problem_schema(404))
def get_report(row: Existing, services: Provided) -> FileResponse:
    """How wrong the picture may be, how that fell with time, and what rendered it."""
    path = _result(row, services, "report.json", summary(row).links.report)
    return FileResponse(path, media_type="application/json")


@router.get("/{id}/report.html", response_class=HTMLResponse, responses=problem_schema(404))
def get_report_page(row: Existing, services: Provided) -> HTMLResponse:
    """The report as a page that fetches nothing: the error against time, the pictures, the certificate."""
    path = _result(row, services, "report.html", summary(row).links.report_page)
    return html_page(path.read_text(encoding="utf-8"))


def html_page(page: str) -> HTMLResponse:
    """A report's page, under the policy that itself states."""
    # Of the version that wrote it, for it names its script by its hash. Sandboxed: it is not of the service's origin.
    own = POLICY.search(page)
    policy = f"{html.unescape(own[1]) if own else NOTHING}; frame-ancestors 'none'; sandbox allow-scripts"
    return HTMLResponse(page, headers={"Content-Security-Policy": policy, "X-Content-Type-Options": "nosniff"})


def _result(row: repository.Row, services: Services, name: str, link: str | None) -> Path:
    if link is None:
        raise HTTPException(404, f"Job {row['id']} has no {name}: it is {row['state']}.")
    path = services.storage.job_file(row["id"], name)
    if not path.is_file():
        message = f"Job {row['id']} has no {name}: it was deleted, or ended under a version that wrote none."
        raise HTTPException(404, message)
    return path
