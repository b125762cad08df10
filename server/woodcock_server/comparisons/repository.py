"""Rows of the table of comparisons."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, RowMapping, delete, insert, select

from woodcock.compare import Variant
from woodcock_server.identifiers import new_id
from woodcock_server.jobs import repository
from woodcock_server.tables import comparisons, jobs


def add(connection: Connection, asked: Mapping[str, Any], variants: Sequence[Variant], now: datetime) -> str:
    """A new comparison, with a job for each variant; returns its id. asked: owner, name, scene, vary, seconds,
    reference and device."""
    comparison_id = new_id()
    made = []
    for variant in variants:
        name = f"{asked['name']}: {variant.label}" if asked["name"] else variant.label
        scene = variant.scene.model_dump(mode="json")
        same = {key: asked[key] for key in ("owner", "device", "reference")}
        job_id = repository.add(
            connection, {"name": name[:200], "scene": scene, "comparison": comparison_id, **same}, now
        )
        made.append({"job": job_id, "label": variant.label, "choices": variant.choices})
    connection.execute(insert(comparisons).values(id=comparison_id, created_at=now, variants=made, **asked))
    return comparison_id


def get(connection: Connection, comparison_id: str) -> RowMapping | None:
    return connection.execute(select(comparisons).where(comparisons.c.id == comparison_id)).mappings().one_or_none()


def remove(connection: Connection, comparison_id: str) -> None:
    connection.execute(delete(comparisons).where(comparisons.c.id == comparison_id))


def jobs_of(connection: Connection, comparison_id: str) -> dict[str, RowMapping]:
    """Its jobs, by id."""
    found = connection.execute(select(jobs).where(jobs.c.comparison == comparison_id)).mappings()
    return {row["id"]: row for row in found}
