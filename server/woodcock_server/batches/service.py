"""Making batches, all or none, and what is done with all jobs of one."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from functools import partial

from fastapi import HTTPException
from pydantic import ValidationError
from sqlalchemy import Connection

from woodcock.scene import Scene, fault, field_path
from woodcock_server.batches import repository, sweep
from woodcock_server.batches.schemas import Batch, BatchCreate, BatchSummary, batch, summary
from woodcock_server.idempotency import keep, once
from woodcock_server.jobs.repository import Row, cancel_batch
from woodcock_server.jobs.requests import RequestCheck
from woodcock_server.jobs.schemas import JobCreate
from woodcock_server.jobs.service import admit, waiting
from woodcock_server.problems import Conflict, Fault, InvalidRequest
from woodcock_server.services import Services

#: Faults that are told; a thousand scenes may have as many.
FEW = 8
#: Characters of a job's name.
LONGEST = 200


def create(services: Services, request: BatchCreate, owner: str, key: str | None) -> Batch:
    """Commit a batch and its jobs, all or none. key: under which the request may come twice. Raises InvalidRequest,
    TooMuch."""
    return once(services.engine, key, owner, request, Batch, partial(_create, services, request, owner, key))


def _create(services: Services, request: BatchCreate, owner: str, key: str | None) -> Batch:
    made = [{**job, "owner": owner} for job in _expanded(services, request)]
    admit(services, owner, [job["scene"] for job in made])
    asked = {**request.model_dump(mode="json", include={"name", "scene", "product", "zip"}), "owner": owner}
    now = datetime.now(UTC)
    with services.engine.begin() as connection:
        batch_id = repository.add(connection, asked, made, now)
        answer = shown(connection, services, existing(connection, batch_id))
        keep(connection, key, owner, request, answer, now)
    return answer


def _expanded(services: Services, request: BatchCreate) -> list[Row]:
    """A job for every point, in order. Raises InvalidRequest if any of them cannot be rendered."""
    scene = request.scene.model_dump(mode="json")
    if wrong := sweep.check(scene, request.product, request.zip):
        faults = (Fault(field=field_path(where), message=message) for where, message in wrong[:FEW])
        raise InvalidRequest("The scene cannot be swept like this.", *faults)
    check = RequestCheck(services)
    check.check_device(request.device)
    swept = sweep.axes(request.product, request.zip)
    same = request.model_dump(exclude={"name", "scene", "product", "zip"})
    made, found = list[Row](), dict[tuple[str, str], Fault]()
    for position in sweep.positions(swept):
        point = sweep.point(swept, position)
        label = sweep.label(point)
        name = f"{request.name}: {label}" if request.name else label
        try:
            one = JobCreate(name=name[:LONGEST], scene=_scene(sweep.placed(scene, point)), **same)
            check.check(one)
        except InvalidRequest as error:
            for each in error.faults:
                field = _value(swept, position, each.field)
                told = each.message if field else f"{each.message}; first at {label}"
                found.setdefault((field or each.field, each.message), Fault(field=field or each.field, message=told))
            if len(found) >= FEW:
                break
        else:
            made.append({**one.model_dump(mode="json"), "point": point})
    if found:
        raise InvalidRequest("The scene cannot be rendered at every point.", *found.values())
    return made


def _scene(values: object) -> Scene:
    """Raises InvalidRequest, with the fields named as a job's request has them."""
    try:
        return Scene.model_validate(values)
    except ValidationError as error:
        found = error.errors(include_url=False)
        faults = (Fault(field=field_path(("scene", *one["loc"])), message=fault(one)) for one in found)
        raise InvalidRequest("The scene is not valid.", *faults) from None


def _value(swept: Sequence[sweep.Axis], position: Sequence[int], field: str) -> str | None:
    """Which value of the request brought a fault of a job's field; None if no value did so alone."""
    for axis, row in zip(swept, position, strict=True):
        for path in axis.paths:
            within = field.removeprefix(f"scene.{path}")
            if within != field and within[:1] in ("", ".", "["):
                return field_path((axis.group, path, row)) + within
    return None


# What is done with all jobs of one


def shown(connection: Connection, services: Services, row: Row) -> Batch:
    rows = repository.jobs_of(connection, row["id"])
    return batch(row, zip(rows, waiting(connection, services.dispatcher, rows), strict=True))


def listed(connection: Connection, limit: int, cursor: str | None) -> tuple[list[BatchSummary], str | None]:
    """A page of batches, and the cursor of the next one."""
    rows, following = repository.page(connection, limit, cursor)
    counts = repository.counts(connection, [row["id"] for row in rows])
    return [summary(row, counts[row["id"]]) for row in rows], following


def cancel(services: Services, row: Row) -> tuple[Batch, list[str]]:
    """The batch afterwards, and which of its jobs are cancelled, or to be so as soon as their holder lets go of them.
    Raises Conflict."""
    with services.engine.begin() as connection:
        cancelled = cancel_batch(connection, row["id"], datetime.now(UTC))
        now = shown(connection, services, row)
        if not cancelled and all(job.state.final for job in now.jobs):
            raise Conflict(f"All jobs of batch {row['id']} have ended. Only what has not can be cancelled.")
        return now, cancelled


def delete(services: Services, row: Row) -> None:
    """Forget a batch, its jobs and their files. Raises Conflict."""
    batch_id = row["id"]
    with services.engine.connect() as connection:
        users = repository.users(connection, batch_id)
    if users:
        raise Conflict(f"Jobs that are held against pictures of batch {batch_id} and have not ended: {len(users)}.")
    with services.engine.begin() as connection:
        removed = repository.remove(connection, batch_id)
        if removed is None:
            states = repository.counts(connection, [existing(connection, batch_id)["id"]])[batch_id]
            left = sum(count for state, count in states.items() if not state.final)
            raise Conflict(f"Jobs of batch {batch_id} that have not ended: {left}. Cancel it first.")
    for job_id in removed:
        services.storage.remove_job(job_id)


def existing(connection: Connection, batch_id: str) -> Row:
    """Raises HTTPException 404."""
    row = repository.get(connection, batch_id)
    if row is None:
        raise HTTPException(404, f"There is no batch {batch_id}.")
    return row
