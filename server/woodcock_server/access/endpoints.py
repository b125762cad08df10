"""/api/v1/session: browsers give their token once, and get a cookie for it."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, Field

from woodcock_server.access import guard
from woodcock_server.access.guard import COOKIE, Given
from woodcock_server.access.tokens import Row, Scope
from woodcock_server.problems import problem_schema
from woodcock_server.services import Provided

router = APIRouter(prefix="/api/v1/session", tags=["session"])

#: How long a browser keeps a token that does not expire, seconds.
KEPT = 30 * 24 * 3600


class SignIn(BaseModel):
    token: Annotated[str, Field(min_length=1, max_length=200)]


class Session(BaseModel):
    """name: the token's, None where nobody needs one; owner: whose jobs it makes."""

    name: str | None
    owner: str
    scope: Scope


@router.get("", responses=problem_schema(401))
def get_session(services: Provided, token: Given) -> Session:
    """As whom the service knows who asks."""
    return _session(guard.holder(services, token))


@router.post("", responses=problem_schema(401))
def sign_in(given: SignIn, request: Request, response: Response, services: Provided) -> Session:
    """Keep a token in a cookie that scripts cannot read and other sites do not send."""
    found = guard.holder(services, given.token)
    if found is not None:  # Else nobody needs one, and none is kept.
        until = found["expires_at"]
        kept = min(KEPT, int((until - datetime.now(UTC)).total_seconds())) if until else KEPT
        response.set_cookie(
            COOKIE, given.token, max_age=kept, httponly=True, samesite="strict", secure=request.url.scheme == "https"
        )
    return _session(found)


def _session(found: Row | None) -> Session:
    return (
        Session(name=found["name"], owner=found["owner"], scope=found["scope"])
        if found
        else Session(name=None, owner="", scope=Scope.ADMIN)
    )


@router.delete("", status_code=204)
def sign_out(response: Response) -> None:
    """Forget the cookie."""
    response.delete_cookie(COOKIE, httponly=True, samesite="strict")
