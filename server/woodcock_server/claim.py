"""A job in the hands of the dispatcher that claimed it: its row, its Film on the disk, and how it ends."""

from __future__ import annotations

from contextlib import nullcontext
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import structlog
from sqlalchemy import Engine

from woodcock.film import Film, FilmError
from woodcock_server.events import Changes
from woodcock_server.jobs import repository
from woodcock_server.jobs.states import State
from woodcock_server.storage import Storage, film_name
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
        self.leaving = False  # the job's next state is being written, or is
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
        """Write the checkpoint, in place of all before it. Raises LeaseLost, OSError, StoreAway."""
        staged = await self.stage()
        await in_thread(film.save, staged / film_name(self.token))
        await self.write({"token": self.token}, publish=True)
        await in_thread(self._storage.drop_checkpoints, self.id, self.token)

    async def stage(self) -> Path:
        """Where files are made that the next write publishes. Raises OSError."""
        return await in_thread(self._storage.stage, self.id, self.token)

    async def write(self, values: dict[str, Any], *, publish: bool = False) -> None:
        """Write to the row, and tell who follows the job. Raises LeaseLost.

        publish: also what is staged, while the row is locked: who lost the lease changes no file. Raises OSError,
        StoreAway.
        """
        if not await in_thread(self._write, values, publish):
            raise LeaseLost
        self._changes.publish(self.id)

    def _write(self, values: dict[str, Any], publish: bool) -> bool:
        self.leaving = self.leaving or "state" in values
        publishing = self._storage.publishing(self.id, self.token) if publish else nullcontext()
        with publishing as put_in_place, self._engine.begin() as connection:
            held = repository.write_held(connection, self.id, self.token, values)
            if held and put_in_place:
                put_in_place(connection)
        if "state" in values:
            self._storage.unstage(self.id, self.token)
        return held

    async def end(self, state: State, error: str | None = None) -> None:
        """The job is over. Raises LeaseLost, OSError, StoreAway."""
        ended = {"state": state, "error": error, "finished_at": datetime.now(UTC), "kept": None, **repository.NOBODY}
        await self.write(ended, publish=state is State.SUCCEEDED)
        # The last Film of a picture stays, to be gone on from.
        before = self.token if state is State.SUCCEEDED else self.token + 1
        try:
            await in_thread(self._storage.drop_checkpoints, self.id, before)
        except OSError as fault:  # The end is written all the same.
            log.warning("checkpoint not removed", reason=str(fault))

    async def put_back(self, values: dict[str, Any]) -> None:
        """Leave the job to the next dispatcher. Raises LeaseLost."""
        await self.write({"state": State.QUEUED, **values, **repository.NOBODY})

    async def let_go(self) -> bool:
        """Of a job that is to be cancelled, so that it is; False if another dispatcher holds it."""
        await in_thread(self._storage.unstage, self.id, self.token)
        cancelled = await in_thread(self._let_go)
        if cancelled:
            self._changes.publish(self.id)
            await in_thread(self._storage.drop_checkpoints, self.id, self.token + 1)
        return cancelled

    def _let_go(self) -> bool:
        with self._engine.begin() as connection:
            return repository.let_go(connection, self.id, self.token, datetime.now(UTC))
