"""Requests that may come twice: who repeats one under the same Idempotency-Key gets the first answer once more.

After draft-ietf-httpapi-idempotency-key-header. The answer is kept in the transaction of what was done, so that either
both are there or neither.
"""

from __future__ import annotations

import hashlib
import json
from datetime import datetime, timedelta
from typing import Annotated, Any

from fastapi import Header
from pydantic import BaseModel
from sqlalchemy import Connection, delete, insert, select

from woodcock_server.problems import Fault, InvalidRequest
from woodcock_server.tables import answers

#: For how long a key is known.
KEPT = timedelta(days=7)

Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=255,
        pattern=r"^[!-~]+$",
        description="Chosen by the client: a request that is repeated under it is done once, and answered alike.",
    ),
]


def digest(request: BaseModel) -> str:
    """Of what a request says."""
    return hashlib.sha256(json.dumps(request.model_dump(mode="json"), sort_keys=True).encode()).hexdigest()


def answered(connection: Connection, key: str, request: BaseModel) -> dict[str, Any] | None:
    """The first answer; None if there was none. Raises InvalidRequest for a key that another request came under."""
    row = connection.execute(select(answers).where(answers.c.key == key)).mappings().one_or_none()
    if row is None:
        return None
    if row["digest"] != digest(request):
        message = "was used for another request; choose a new one for every job"
        raise InvalidRequest("The key belongs to another request.", Fault(field="Idempotency-Key", message=message))
    answer: dict[str, Any] = row["answer"]
    return answer


def keep(connection: Connection, key: str, request: BaseModel, answer: BaseModel, now: datetime) -> None:
    """Raises sqlalchemy.exc.IntegrityError where the same request came in at the same time and was faster."""
    connection.execute(delete(answers).where(answers.c.created_at < now - KEPT))
    values = {"key": key, "digest": digest(request), "answer": answer.model_dump(mode="json"), "created_at": now}
    connection.execute(insert(answers).values(**values))
