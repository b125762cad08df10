"""Requests that may come twice: who repeats one under the same Idempotency-Key gets the first answer once more.

After draft-ietf-httpapi-idempotency-key-header. The answer is kept in the transaction of what was done, so that either
both are there or neither.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from datetime import datetime, timedelta
from typing import Annotated, Any, TypeVar

from fastapi import Header
from pydantic import BaseModel
from sqlalchemy import Connection, Engine, delete, insert, select
from sqlalchemy.exc import IntegrityError

from woodcock_server.problems import Fault, InvalidRequest
from woodcock_server.tables import answers

Answer = TypeVar("Answer", bound=BaseModel)

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


def once(
    engine: Engine, key: str | None, owner: str, request: BaseModel, answer: type[Answer], do: Callable[[], Answer]
) -> Answer:
    """What `do` answers, which keeps it under the key; or the first answer, if the request came under that before.

    Raises InvalidRequest for a key that another request came under.
    """
    first = _answered(engine, _own(key, owner), request)
    if first is None:
        try:
            return do()
        except IntegrityError:
            # The same request came in at the same time, and was faster; or what this one needs has just gone, and is
            # missed at the second look.
            first = _answered(engine, _own(key, owner), request)
    return do() if first is None else answer.model_validate(first)


def keep(
    connection: Connection, key: str | None, owner: str, request: BaseModel, answer: BaseModel, now: datetime
) -> None:
    """Where there is a key. Raises sqlalchemy.exc.IntegrityError where the same request came in at the same time and
    was faster."""
    if key is None:
        return
    connection.execute(delete(answers).where(answers.c.created_at < now - KEPT))
    values = {
        "key": _own(key, owner),
        "digest": _digest(request),
        "answer": answer.model_dump(mode="json"),
        "created_at": now,
    }
    connection.execute(insert(answers).values(**values))


def _own(key: str | None, owner: str) -> str | None:
    """Owners choose keys without knowing of each other; who has no name has them as they are."""
    return hashlib.sha256(f"{owner}\0{key}".encode()).hexdigest() if key and owner else key


def _answered(engine: Engine, key: str | None, request: BaseModel) -> dict[str, Any] | None:
    if key is None:
        return None
    with engine.connect() as connection:
        row = connection.execute(select(answers).where(answers.c.key == key)).mappings().one_or_none()
    if row is None:
        return None
    if row["digest"] != _digest(request):
        message = "was used for another request; choose a new one for each"
        raise InvalidRequest("The key belongs to another request.", Fault(field="Idempotency-Key", message=message))
    first: dict[str, Any] = row["answer"]
    return first


def _digest(request: BaseModel) -> str:
    """Of what a request says. Requests of different routes have different fields, so they never say the same."""
    return hashlib.sha256(json.dumps(request.model_dump(mode="json"), sort_keys=True).encode()).hexdigest()
