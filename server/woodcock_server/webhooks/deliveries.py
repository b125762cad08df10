"""Tells whoever asked for it of the ends of jobs: again and again, until he has heard or it is given up."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime, timedelta
from http import HTTPStatus
from typing import Any

import structlog
from sqlalchemy import Engine, RowMapping
from sqlalchemy.exc import SQLAlchemyError

from woodcock_server.jobs import repository as jobs
from woodcock_server.jobs.schemas import summary
from woodcock_server.threads import in_thread
from woodcock_server.webhooks import repository, signature
from woodcock_server.webhooks.network import Network
from woodcock_server.webhooks.schemas import DeliveryState
from woodcock_server.webhooks.sending import Sender, Undelivered

log = structlog.get_logger()

#: How often the outbox is looked at, seconds.
LOOK_EVERY = 1.0
#: Attempts that are made at the same time.
TOGETHER = 32
#: One attempt takes so long at most, seconds.
LIMIT = 15.0
#: Between an attempt that failed and the next one, seconds; after the last of these it is given up.
PAUSES = (5.0, 30.0, 300.0, 1800.0, 7200.0, 28800.0, 86400.0)


class Deliveries:
    """Sends what is due. Servers that share a database share the work.

    allowed: internal networks that receivers may be in; limit, pauses: as LIMIT and PAUSES.
    """

    def __init__(
        self, engine: Engine, allowed: Sequence[Network], limit: float = LIMIT, pauses: Sequence[float] = PAUSES
    ) -> None:
        self._engine, self._pauses = engine, pauses
        self._sender = Sender(allowed, limit)
        # Who is killed during an attempt does not write down what came of it: it is made again after this.
        self._lease = timedelta(seconds=4 * limit)

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Send in the background; an attempt that the end cuts off is made again by whoever comes next."""
        task = asyncio.create_task(self._run(), name="webhooks")
        try:
            yield
        finally:
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task
            self._sender.close()

    async def _run(self) -> None:
        while True:
            try:
                if await self.send_due():
                    continue
            except SQLAlchemyError as error:
                # What was taken is due again when its lease has run out.
                log.error("the database does not answer", error=str(error))
            except Exception:  # One message's trouble must not be the end of all.
                log.exception("the webhooks stumbled")
            await asyncio.sleep(LOOK_EVERY)

    async def send_due(self) -> bool:
        """Make the attempts that are due, at the same time; False if there is none. Raises SQLAlchemyError."""
        taken = await in_thread(self._take)
        outcomes = await asyncio.gather(*map(self._attempt, taken), return_exceptions=True)
        for error in filter(None, outcomes):
            raise error
        return bool(taken)

    def _take(self) -> Sequence[RowMapping]:
        now = datetime.now(UTC)
        with self._engine.connect() as connection:
            if not repository.any_due(connection, now):
                return ()
        with self._engine.begin() as connection:
            return repository.take(connection, now, now + self._lease, TOGETHER)

    async def _attempt(self, taken: RowMapping) -> None:
        """Make it, and write down what came of it. Raises SQLAlchemyError."""
        job_id, attempt = taken["job_id"], taken["attempts"]
        outcome: dict[str, Any] = {"state": DeliveryState.DELIVERED, "due_at": None, "error": None}
        try:
            await self._send(job_id, taken["url"], taken["secret"])
        except Undelivered as error:
            if error.final or attempt > len(self._pauses):
                outcome |= {"state": DeliveryState.GIVEN_UP, "error": str(error)}
                log.warning("webhook given up", job=job_id, attempts=attempt, reason=str(error))
            else:
                due = datetime.now(UTC) + timedelta(seconds=self._pauses[attempt - 1])
                outcome = {"due_at": due, "error": str(error)}
                log.info("webhook not delivered", job=job_id, attempt=attempt, reason=str(error))
        await in_thread(self._write, job_id, attempt, outcome)

    def _write(self, job_id: str, attempt: int, outcome: dict[str, Any]) -> None:
        with self._engine.begin() as connection:
            repository.write_taken(connection, job_id, attempt, **outcome)

    async def _send(self, job_id: str, url: str, secret: str) -> None:
        """Raises Undelivered, SQLAlchemyError."""
        try:
            body = await in_thread(self._message, job_id)
            proof = signature.headers(job_id, int(datetime.now(UTC).timestamp()), body, secret)
            status = await self._sender.post(url, proof, body)
        except (Undelivered, SQLAlchemyError):
            raise
        except Exception as error:
            log.exception("webhook broke off", job=job_id)
            raise Undelivered("It could not be sent; the server's log says why.") from error
        if not 200 <= status < 300:
            raise Undelivered(f"The receiver answered {status}.", final=status == HTTPStatus.GONE)

    def _message(self, job_id: str) -> bytes:
        """The same in every attempt, unless the job's name or tags are changed meanwhile. Raises Undelivered."""
        with self._engine.connect() as connection:
            row = jobs.get(connection, job_id)
        if row is None:
            raise Undelivered("The job was deleted.", final=True)
        data = summary(row).model_dump(mode="json", exclude={"webhook"})
        return json.dumps({"type": f"job.{data['state']}", "timestamp": data["finished_at"], "data": data}).encode()
