"""Answers that need not come again: who has one already is told that it still holds (RFC 9110, 8.8.3 and 13.1.2)."""

from __future__ import annotations

import hashlib
from typing import Any

from fastapi import Request, Response
from pydantic import BaseModel

#: What an endpoint's OpenAPI says of it.
UNCHANGED: dict[int | str, dict[str, Any]] = {304: {"description": "What the client has (If-None-Match) still holds."}}


def unchanged(request: Request, response: Response, answer: BaseModel) -> Response | None:
    """Give the answer its ETag; a 304 in its place if the client has it."""
    tag = f'"{hashlib.sha256(answer.model_dump_json().encode()).hexdigest()[:32]}"'
    response.headers["ETag"] = tag
    known = [one.strip().removeprefix("W/") for one in request.headers.get("If-None-Match", "").split(",")]
    return Response(status_code=304, headers=dict(response.headers)) if tag in known or "*" in known else None
