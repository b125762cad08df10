"""Errors as RFC 9457 problems: every answer that is not a success is `application/problem+json`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import Any

import structlog
from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.routing import Match
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from woodcock.scene import fault, field_path
from woodcock_server.storage import StoreAway

log = structlog.get_logger()


class Fault(BaseModel):
    """What is wrong with one field."""

    field: str
    message: str


class Problem(BaseModel):
    """RFC 9457; `errors` only where fields are at fault."""

    type: str = "about:blank"
    title: str
    status: int
    detail: str
    errors: list[Fault] | None = None


class ProblemResponse(JSONResponse):
    media_type = "application/problem+json"


class InvalidRequest(Exception):  # noqa: N818 - it names what was asked
    """A 422 that names the fields at fault."""

    def __init__(self, detail: str, *faults: Fault) -> None:
        super().__init__(detail)
        self.detail = detail
        self.faults = faults


class Conflict(Exception):  # noqa: N818 - it names what was asked
    """A 409: the request does not fit what state things are in."""


class TooMuch(HTTPException):
    """A 429: what is asked for would be granted later."""

    def __init__(self, says: str, seconds: int) -> None:
        """seconds: when to come again."""
        super().__init__(429, says, headers={"Retry-After": str(seconds)})


def install(app: FastAPI) -> None:
    """Answer every error with a problem."""

    @app.exception_handler(HTTPException)
    def http_error(request: Request, error: HTTPException) -> ProblemResponse:
        headers = {"Allow": _allowed(app, request)} if error.status_code == 405 else error.headers
        return respond(error.status_code, str(error.detail), headers=headers)

    @app.exception_handler(RequestValidationError)
    def validation_error(_request: Request, error: RequestValidationError) -> ProblemResponse:
        faults = [_fault(one) for one in error.errors()]
        count = "one fault" if len(faults) == 1 else f"{len(faults)} faults"
        return respond(422, f"The request has {count}.", faults)

    @app.exception_handler(InvalidRequest)
    def invalid_request(_request: Request, error: InvalidRequest) -> ProblemResponse:
        return respond(422, error.detail, error.faults)

    @app.exception_handler(Conflict)
    def conflict(_request: Request, error: Conflict) -> ProblemResponse:
        return respond(409, str(error))

    @app.exception_handler(StoreAway)
    def away(_request: Request, error: StoreAway) -> ProblemResponse:
        return respond(503, str(error))

    @app.exception_handler(ClientDisconnect)
    def gone(_request: Request, _error: ClientDisconnect) -> ProblemResponse:
        return respond(400, "The connection closed before the body was complete.")

    @app.exception_handler(Exception)
    def internal_error(request: Request, error: Exception) -> ProblemResponse:
        log.error("request failed", method=request.method, path=request.url.path, exc_info=error)
        return respond(500, "The server failed to answer; its log says why.")


def _allowed(app: FastAPI, request: Request) -> str:
    """The methods of all routes of a path; Starlette tells those of the first one alone."""
    scope, methods = dict(request.scope), set[str]()
    for route in app.routes:
        match, _ = route.matches(scope)
        if match is not Match.NONE:
            methods |= getattr(route, "methods", None) or set()
    return ", ".join(sorted(methods))


def respond(
    status: int, detail: str, faults: Sequence[Fault] = (), headers: Mapping[str, str] | None = None
) -> ProblemResponse:
    title = HTTPStatus(status).phrase
    problem = Problem(title=title, status=status, detail=detail, errors=list(faults) or None)
    return ProblemResponse(problem.model_dump(exclude_none=True), status, headers)


def _fault(error: dict[str, Any]) -> Fault:
    where, *loc = error["loc"]
    if error["type"] == "json_invalid":
        return Fault(field="body", message=f"is not JSON: {error['ctx']['error']} at character {loc[0]}")
    if where == "body" and not loc:
        return Fault(field="body", message="must be a JSON object, sent as application/json")
    if "webhook" in loc:  # What was given there may be the secret, under whatever name: it is not told back.
        error = {**error, "input": None}
    # The scene's own wording, which names the field as the scene is written.
    return Fault(field=field_path(loc), message=fault(error))


class BodyLimit:
    """Refuse bodies above a limit, by their announced length and by what really comes in.

    FastAPI's own limit answers an announced length in plain text, which no handler can turn into a problem.
    """

    def __init__(self, app: ASGIApp, limit: int, special: Mapping[str, int]) -> None:
        self.app = app
        self.limit = limit
        self.special = special

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self.app(scope, receive, send)
        limit = self.special.get(scope["path"], self.limit)
        announced = next((value for name, value in scope["headers"] if name == b"content-length"), b"0")
        if int(announced) > limit:
            return await _too_large(limit)(scope, receive, send)
        total = 0

        async def limited() -> Message:
            nonlocal total
            message = await receive()
            total += len(message.get("body", b""))
            if total > limit:
                raise HTTPException(413, _sentence(limit))
            return message

        return await self.app(scope, limited, send)


def _too_large(limit: int) -> ProblemResponse:
    return respond(413, _sentence(limit))


def _sentence(limit: int) -> str:
    return f"The body is larger than the {limit} bytes that are accepted here."


def problem_schema(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """What an endpoint's OpenAPI says of its errors."""
    schema = Problem.model_json_schema()
    # A schema within another document has no definitions of its own.
    schema["properties"]["errors"]["anyOf"][0]["items"] = schema.pop("$defs")["Fault"]
    content = {"application/problem+json": {"schema": schema}}
    return {status: {"description": HTTPStatus(status).phrase, "content": content} for status in statuses}
