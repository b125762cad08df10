"""What one owner may have at a time: jobs that have not ended, samples that they ask for, room for files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, func, select

from woodcock_server.jobs import repository
from woodcock_server.jobs.states import UNENDED
from woodcock_server.problems import Fault, InvalidRequest, TooMuch
from woodcock_server.tables import jobs, volumes

#: When to come again, seconds: jobs end by themselves, room is made by hand or by retention.
AFTER_A_JOB, AFTER_ROOM = 30, 3600


@dataclass(frozen=True)
class Limits:
    """Of each owner; None for none. jobs: that have not ended; paths: samples × pixels of these; storage: bytes."""

    jobs: int
    paths: int | None
    storage: int | None

    def check(self, connection: Connection, owner: str, scenes: Sequence[Mapping[str, Any]]) -> None:
        """May the owner have jobs that render these scenes (JSON), too? Raises TooMuch, and InvalidRequest for what no
        waiting would help."""
        if len(scenes) > self.jobs:
            raise InvalidRequest(f"{len(scenes)} jobs are more than one owner may have here at a time, {self.jobs}.")
        asked = sum(map(repository.paths, scenes))
        if self.paths is not None and asked > self.paths:
            fault = Fault(field="scene.stop", message=f"asks for {asked} samples of pixels; {self.paths} at most")
            raise InvalidRequest("This is more than one owner may have rendered here.", fault)
        query = select(func.count(), func.coalesce(func.sum(jobs.c.paths), 0))
        count, paths = connection.execute(query.where(jobs.c.owner == owner, jobs.c.state.in_(UNENDED))).one()
        if count + len(scenes) > self.jobs:
            raise TooMuch(f"{count} of your jobs have not ended; {self.jobs} may wait at a time.", AFTER_A_JOB)
        if self.paths is not None and paths + asked > self.paths:
            says = f"Your jobs that have not ended ask for {paths} samples of pixels; this one would make it more than"
            raise TooMuch(f"{says} {self.paths}.", AFTER_A_JOB)
        self.check_room(connection, owner)

    def check_room(self, connection: Connection, owner: str, more: int = 0) -> None:
        """May the owner keep so many bytes more? Raises TooMuch."""
        if self.storage is None:
            return
        kept = sum(
            connection.scalar(select(func.coalesce(func.sum(table.c.size), 0)).where(table.c.owner == owner)) or 0
            for table in (jobs, volumes)
        )
        if kept + more > self.storage:
            says = (
                f"Your uploads and renders take {kept} bytes; {self.storage} may be kept. Delete what you do not need."
            )
            raise TooMuch(says, AFTER_ROOM)
