"""A job in the hands of the dispatcher that claimed it: its row, its Film on the disk, and how it ends."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import structlog
from sqlalchemy import Engine

from woodcock.film import Film, FilmError
from woodcock_server.events import Changes
from woodcock_server.jobs import repository
from woodcock_server.jobs.states import State
from woodcock_server.storage import Storage
from woodcock_server.threads import in_thread

log = structlog.get_logger()


class LeaseLost(Exception):  # noqa: N818 - it says what happened
    """Another dispatcher holds the job now, or it is to be cancelled; what this one still does must leave no trace."""


class Claim:
    """Every write names the token of the claim, so one that is no longer held changes nothing.

    row: as it was claimed.
    """

    def __init__(self, engine: Engine, storage: Storage, changes: Changes, row: repository.Row) -> None:
        self.row = row
        self.id: str = row["id"]
        self.token: int = row["token"]
        self._engine, self._storage, self._changes = engine, storage, changes

    async def resume(self) -> Film | None:
        """What former attempts left."""
        if path := await in_thread(self._storage.newest_checkpoint, self.id):
            try:
                return await in_thread(Film.load, path)
            except FilmError as error:
                log.error("checkpoint lost, starting again", reason=str(error))
        return None

    async def keep(self, film: Film) -> None:
        """Write the checkpoint, in place of all before it."""
        await in_thread(film.save, self._storage.checkpoint(self.id, self.token))
        await in_thread(self._storage.drop_checkpoints, self.id, self.token)

    async def write(self, values: dict[str, Any]) -> None:
        """Write to the row, and tell who follows the job. Raises LeaseLost."""
        if not await in_thread(self._write, values):
            raise LeaseLost
        self._changes.publish(self.id)

    def _write(self, values: dict[str, Any]) -> bool:
        with self._engine.begin() as connection:
            return repository.write_held(connection, self.id, self.token, values)

    async def end(self, state: State, error: str | None = None) -> None:
        """The job is over. Raises LeaseLost."""
        await self.write(
            {"state": state, "error": error, "finished_at": datetime.now(UTC), "kept": None, **repository.NOBODY}
        )
        # The last Film of a picture stays, to be gone on from.
        before = self.token if state is State.SUCCEEDED else self.token + 1
        await in_thread(self._storage.drop_checkpoints, self.id, before)

    async def put_back(self, values: dict[str, Any]) -> None:
        """Leave the job to the next dispatcher. Raises LeaseLost."""
        await self.write({"state": State.QUEUED, **values, **repository.NOBODY})

    async def let_go(self) -> bool:
        """Of a job that is to be cancelled, so that it is; False if another dispatcher holds it."""
        cancelled = await in_thread(self._let_go)
        if cancelled:
            self._changes.publish(self.id)
            await in_thread(self._storage.drop_checkpoints, self.id, self.token + 1)
        return cancelled

    def _let_go(self) -> bool:
        with self._engine.begin() as connection:
            return repository.let_go(connection, self.id, self.token, datetime.now(UTC))
