"""Making comparisons, and judging them once their jobs have ended."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import structlog
from sqlalchemy import RowMapping

from woodcock.compare import CompareError, Verdict, of_series, row, seeded, variants, winner
from woodcock.compare.agreement import of_reference
from woodcock.compare.judge import Row
from woodcock.compare.page import page
from woodcock.film import Film
from woodcock.image import ImageError
from woodcock.layers import beauty_names
from woodcock.pages import words
from woodcock.picture import read_picture, read_variance
from woodcock.scene import Scene, SecondsStop
from woodcock_server.comparisons import repository
from woodcock_server.comparisons.schemas import MOST_VARIANTS, ComparisonCreate
from woodcock_server.devices.choice import leaves_a_choice, meant
from woodcock_server.jobs import reference
from woodcock_server.jobs.requests import RequestCheck
from woodcock_server.jobs.schemas import JobCreate
from woodcock_server.jobs.service import admit
from woodcock_server.jobs.states import State
from woodcock_server.problems import Fault, InvalidRequest
from woodcock_server.services import Services
from woodcock_server.storage import Storage, as_json

log = structlog.get_logger()

RESULT, PAGE = "comparison.json", "report.html"


def create(services: Services, request: ComparisonCreate, owner: str) -> RowMapping:
    """Commit a comparison and its jobs, all or none. Raises InvalidRequest, TooMuch."""
    scene = request.scene.model_copy(update={"stop": SecondsStop(seconds=request.seconds)})
    try:
        made = variants(scene, request.vary)
    except CompareError as error:
        raise _invalid(str(error)) from None
    if len(made) > MOST_VARIANTS:
        raise _invalid(f"must make {MOST_VARIANTS} variants at most; this makes {len(made)}")
    check = RequestCheck(services)
    for variant in made:
        check.check(JobCreate(scene=variant.scene, device=request.device, reference=request.reference))
    taken = None if request.reference is None else reference.load(services.storage, request.reference).seed
    own = seeded(made, scene.seed, taken)
    values = request.model_dump(mode="json") | {"device": _device(services, request.device), "owner": owner}
    admit(services, owner, [variant.scene.model_dump(mode="json") for variant in own])
    with services.engine.begin() as connection:
        comparison_id = repository.add(connection, values, own, datetime.now(UTC))
    with services.engine.connect() as connection:
        found = repository.get(connection, comparison_id)
    assert found is not None, "comparisons are never deleted"
    return found


def _invalid(message: str) -> InvalidRequest:
    return InvalidRequest("These variants cannot be compared.", Fault(field="vary", message=message))


def _device(services: Services, asked: str) -> str:
    """One for all: of several that rendered a job together nobody could tell what each took."""
    if not leaves_a_choice(asked):
        return asked
    with services.engine.connect() as connection:
        distrusted = services.checks.distrusted(connection)
    able = (one.id for one in meant(asked, services.devices) if one.ready and one.id not in distrusted)
    return next(able, asked)


def state(jobs: Sequence[RowMapping]) -> State:
    states = [State(job["state"]) for job in jobs]
    if all(each.final for each in states):
        return State.SUCCEEDED if states.count(State.SUCCEEDED) >= 2 else State.FAILED
    return State.QUEUED if all(each is State.QUEUED for each in states) else State.RUNNING


def judged(storage: Storage, comparison: RowMapping, jobs: Mapping[str, RowMapping]) -> dict[str, Any] | None:
    """Rows and verdict of a comparison that has succeeded; they, and the page, are made once. None if that fails: its
    pictures or its reference are gone."""
    if not storage.job_file(comparison["id"], RESULT).exists():
        try:
            _judge(storage, comparison, jobs)
        except (ImageError, OSError) as error:
            log.error("comparison not judged", comparison=comparison["id"], reason=str(error))
            return None
    result: dict[str, Any] = json.loads(storage.job_file(comparison["id"], RESULT).read_text(encoding="utf-8"))
    return result


def _judge(storage: Storage, comparison: RowMapping, jobs: Mapping[str, RowMapping]) -> None:
    """Write the page, then the result. Raises ImageError, OSError."""
    rows, films, ids = list[Row](), dict[str, Film](), dict[str, str]()
    hashes, same = dict[str, str](), dict[str, str]()
    for variant in comparison["variants"]:
        if jobs[variant["job"]]["state"] != State.SUCCEEDED:
            continue
        label = variant["label"]
        report = json.loads(storage.job_file(variant["job"], "report.json").read_text(encoding="utf-8"))
        if report["program_hash"] in hashes:
            same[label] = hashes[report["program_hash"]]
            continue
        hashes[report["program_hash"]] = label
        films[label] = film_of(storage.job_file(variant["job"], "image.exr"), report)
        ids[label] = variant["job"]
        rows.append(_row(label, variant["choices"], films[label], report, comparison["scene"]))
    truth = None if comparison["reference"] is None else reference.load(storage, comparison["reference"])
    verdict = winner(rows, None if truth is None else of_reference(truth))
    storage.open_job(comparison["id"])
    if len(rows) > 1:
        scene, title = Scene.model_validate(comparison["scene"]), comparison["name"] or "Untitled"
        text = page(title, rows, verdict, films, scene, _measured(comparison, rows), same)
        storage.write_text(comparison["id"], PAGE, text)
    else:
        verdict["winner"], verdict["says"] = None, "No winner: all variants compile to the same program."
    storage.write_text(comparison["id"], RESULT, as_json(_result(rows, ids, verdict, same)))


def film_of(path: Path, report: Mapping[str, Any]) -> Film:
    """The beauty of a finished job, of as many samples everywhere. Raises ImageError."""
    mean = read_picture(path).astype(np.float64)
    variance, _ = read_variance(path)
    height, width, channels = mean.shape
    count = report["samples"]
    m2 = np.zeros(mean.shape) if variance is None else np.nan_to_num(variance.astype(np.float64)) * count * (count - 1)
    bound = np.full(mean.shape, report["bound"]["largest"] or 0.0) if report["bound"] else None
    counts = np.full((height, width), count, np.uint32)
    return Film(counts, mean, m2, beauty_names(channels), ((0, count),), bound=bound)


def _row(label: str, choices: dict[str, str], film: Film, report: Mapping[str, Any], scene: Mapping[str, Any]) -> Row:
    seconds = report["seconds"]
    found = row(
        label,
        choices,
        film,
        of_series(report["error"]),
        report["error"],
        build_seconds=sum(seconds[part] for part in ("read", "build", "upload")),
        default=all((scene[field] or {}).get("kind") == kind for field, kind in choices.items()),
        against=report["against"],
    )
    return {**found, "seconds": seconds["render"]}


def _measured(comparison: RowMapping, rows: Sequence[Row]) -> list[tuple[str, str]]:
    """How it was made, as names and texts."""
    slices = [len(row["slices"]) for row in rows]
    seconds = words.duration(comparison["seconds"])
    return [
        ("device", comparison["device"]),
        ("time", f"{seconds} of rendering for each, wall clock; reading and building do not count"),
        (
            "turns",
            "none: one job after the other, not interleaved. What changed on the machine from one to the next counts "
            "as a difference between them; `woodcock compare` takes turns.",
        ),
        (
            "efficiency",
            "1 ∕ (variance × seconds): the variance of a pixel’s mean, weighted by luminance; seconds of the device",
        ),
        (
            "intervals",
            "95 %, of the ratio of two: Student’s t by the jackknife over what lies between points of the error "
            f"series, {min(slices)} to {max(slices)} of them",
        ),
        ("winner", "its ratio to every other is above 1 with that confidence; else it is a draw"),
    ]


def _result(rows: Sequence[Row], ids: Mapping[str, str], verdict: Verdict, same: Mapping[str, str]) -> dict[str, Any]:
    shown = (
        "label",
        "choices",
        "seconds",
        "build_seconds",
        "samples",
        "rmse",
        "deterministic",
        "efficiency",
        "against",
    )
    ratios = verdict["ratios"]
    told: dict[str, Any] = {key: value for key, value in verdict.items() if key != "ratios"}
    return {
        "rows": [
            {**{key: row[key] for key in shown}, "job": ids[row["label"]], "ratio": ratios.get(row["label"])}  # type: ignore[literal-required]
            for row in rows
        ],
        "verdict": {**told, "same": dict(same)},
    }
