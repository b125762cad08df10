"""What would be deleted: renders that are too old or take too much room, oldest first, and files that none names."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta

from sqlalchemy import Connection, exists, func, select

from woodcock_server.jobs.states import FINAL
from woodcock_server.tables import job_files, jobs, volumes

#: Who uploads a file has so long to submit what names it.
GRACE = timedelta(days=1)


@dataclass(frozen=True)
class Rule:
    """days: since their end; size: of all renders and uploads, bytes. None for no limit."""

    days: float | None
    size: int | None

    @property
    def idle(self) -> bool:
        return self.days is None and self.size is None


@dataclass(frozen=True)
class Group:
    """What is deleted together: a job, or the variants of a comparison. finished_at: of the last; size: in bytes."""

    comparison: str | None
    jobs: tuple[str, ...]
    name: str
    finished_at: datetime
    size: int


@dataclass(frozen=True)
class File:
    id: str
    name: str
    size: int


@dataclass(frozen=True)
class Due:
    """kept: bytes that renders and uploads take now."""

    groups: list[Group]
    files: list[File]
    kept: int

    @property
    def freed(self) -> int:
        """Of these, what deleting frees."""
        return sum(group.size for group in self.groups) + sum(file.size for file in self.files)


def due(connection: Connection, rule: Rule, now: datetime) -> Due:
    kept = sum(connection.scalar(select(func.coalesce(func.sum(table.c.size), 0))) or 0 for table in (jobs, volumes))
    if rule.idle:
        return Due([], [], kept)
    files = _unused(connection, now, ())
    left, groups = kept - sum(file.size for file in files), []
    for group in _removable(connection):
        old = rule.days is not None and group.finished_at < now - timedelta(days=rule.days)
        if not old and (rule.size is None or left <= rule.size):
            break  # Those that follow are younger.
        groups.append(group)
        left -= group.size
    gone = {job for group in groups for job in group.jobs}
    return Due(groups, _unused(connection, now, gone), kept)


def _removable(connection: Connection) -> Iterator[Group]:
    """Oldest first: what has ended, nobody pinned, and nothing that has not ended is held against."""
    user = jobs.alias()
    needed = exists().where(user.c.reference == jobs.c.id, user.c.state.not_in(FINAL))
    found = connection.execute(
        select(jobs.c.comparison, jobs.c.id, jobs.c.name, jobs.c.finished_at, func.coalesce(jobs.c.size, 0))
        .where(jobs.c.state.in_(FINAL), ~jobs.c.pinned, ~needed)
        .order_by(jobs.c.finished_at, jobs.c.id)
    )
    variants = select(jobs.c.comparison, func.count().label("number")).group_by(jobs.c.comparison)
    number = {row.comparison: row.number for row in connection.execute(variants)}
    together = defaultdict[str, dict[str, int]](dict)
    for comparison, id, name, finished_at, size in found:
        if comparison is None:
            yield Group(None, (id,), name, finished_at, size)
            continue
        sizes = together[comparison]
        sizes[id] = size
        if len(sizes) == number[comparison]:  # The last of them to end.
            yield Group(comparison, tuple(sizes), name, finished_at, sum(sizes.values()))


def _unused(connection: Connection, now: datetime, gone: Collection[str]) -> list[File]:
    """Files that no job names but those that are gone."""
    pairs = connection.execute(select(job_files.c.file, job_files.c.job_id))
    used = {file for file, job in pairs if job not in gone}
    query = select(volumes.c.id, volumes.c.name, volumes.c.size).where(volumes.c.used_at < now - GRACE)
    return [File(*row) for row in connection.execute(query.order_by(volumes.c.entry)) if row.id not in used]
