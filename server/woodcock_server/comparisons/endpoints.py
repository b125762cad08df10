"""/api/v1/comparisons"""

from __future__ import annotations

from typing import Annotated

from anyio import to_thread
from fastapi import APIRouter, Depends, HTTPException, Response
from fastapi.responses import HTMLResponse
from sqlalchemy import RowMapping

from woodcock_server.access.guard import Owner
from woodcock_server.comparisons import repository, service
from woodcock_server.comparisons.schemas import PREFIX, ComparedJob, Comparison, ComparisonCreate, Links
from woodcock_server.jobs.endpoints import html_page
from woodcock_server.jobs.schemas import PREFIX as JOBS
from woodcock_server.jobs.states import State
from woodcock_server.problems import problem_schema
from woodcock_server.services import Provided, Services

router = APIRouter(prefix=PREFIX, tags=["comparisons"])


def _existing(id: str, services: Provided) -> RowMapping:
    with services.engine.connect() as connection:
        row = repository.get(connection, id)
    if row is None:
        raise HTTPException(404, f"There is no comparison {id}.")
    return row


Existing = Annotated[RowMapping, Depends(_existing)]


@router.post("", status_code=201, responses=problem_schema(413, 429))
async def compare(request: ComparisonCreate, response: Response, services: Provided, owner: Owner) -> Comparison:
    """Queue a job for each variant of a scene; they are in the database before this answers, all or none."""
    row = await to_thread.run_sync(service.create, services, request, owner)
    services.dispatcher.wake()
    response.headers["Location"] = f"{PREFIX}/{row['id']}"
    return await to_thread.run_sync(_shown, row, services)


@router.get("/{id}", responses=problem_schema(404))
def get_comparison(row: Existing, services: Provided) -> Comparison:
    """A comparison with its jobs; and, once they have ended, which variant wins and by how much."""
    return _shown(row, services)


@router.get("/{id}/report.html", response_class=HTMLResponse, responses=problem_schema(404))
def get_comparison_page(row: Existing, services: Provided) -> HTMLResponse:
    """The comparison as a page that fetches nothing: the verdict, error against time, the pictures."""
    shown = _shown(row, services)
    if shown.links.report is None:
        why = "no two of its variants could be compared" if shown.state.final else f"it is {shown.state}"
        raise HTTPException(404, f"Comparison {row['id']} has no report.html: {why}.")
    return html_page(services.storage.job_file(row["id"], service.PAGE).read_text(encoding="utf-8"))


def _shown(row: RowMapping, services: Services) -> Comparison:
    with services.engine.connect() as connection:
        jobs = repository.jobs_of(connection, row["id"])
    state = service.state(list(jobs.values()))
    judged = service.judged(services.storage, row, jobs) if state is State.SUCCEEDED else None
    path = f"{PREFIX}/{row['id']}"
    return Comparison.model_validate(
        {
            **{key: row[key] for key in Comparison.model_fields if key in row},
            "state": state,
            "jobs": [_job(jobs[variant["job"]], variant["label"], variant["choices"]) for variant in row["variants"]],
            "rows": judged and judged["rows"],
            "verdict": judged and judged["verdict"],
            "links": Links(self=path, report=f"{path}/{service.PAGE}" if judged and len(judged["rows"]) > 1 else None),
        }
    )


def _job(job: RowMapping, label: str, choices: dict[str, str]) -> ComparedJob:
    link = f"{JOBS}/{job['id']}"
    return ComparedJob(
        id=job["id"], label=label, choices=choices, state=State(job["state"]), error=job["error"], link=link
    )
