"""Answers that need not come again: who has one already is told that it still holds (RFC 9110, 8.8.3 and 13.1.2)."""

from __future__ import annotations

import hashlib
from typing import Any

from fastapi import Request, Response
from pydantic import BaseModel

#: What an endpoint's OpenAPI says of it.
UNCHANGED: dict[int | str, dict[str, Any]] = {304: {"description": "What the client has (If-None-Match) still holds."}}


def tagged(request: Request, response: Response, answer: BaseModel) -> Response:
    """The answer with its ETag; a 304 in its place if the client has it. response: whose headers go along."""
    content = answer.model_dump_json().encode()
    tag = f'"{hashlib.sha256(content).hexdigest()[:32]}"'
    headers = {**response.headers, "ETag": tag}
    known = [one.strip().removeprefix("W/") for one in request.headers.get("If-None-Match", "").split(",")]
    if tag in known or "*" in known:
        return Response(status_code=304, headers=headers)
    return Response(content, media_type="application/json", headers=headers)
