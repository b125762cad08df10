"""Who may come in: what every route but the public ones asks first.

As long as no token was ever made, whoever reaches the service may do everything; it listens on the loopback then, or
was told to be insecure. From the first token on every request needs one: of the scope `read` to look, `write` for every
other method, `admin` where a route says so.
"""

from __future__ import annotations

import ipaddress
import socket
from datetime import UTC, datetime
from typing import Annotated

from fastapi import Depends, HTTPException, Request
from fastapi.security import APIKeyCookie, HTTPAuthorizationCredentials, HTTPBearer
from sqlalchemy import Engine

from woodcock_server.access import tokens
from woodcock_server.access.tokens import Scope
from woodcock_server.services import Provided, Services

#: The cookie in which a browser keeps its token: scripts cannot read it, and images come with it.
COOKIE = "woodcock_token"
READING = ("GET", "HEAD", "OPTIONS")


def _given(
    bearer: Annotated[HTTPAuthorizationCredentials | None, Depends(HTTPBearer(auto_error=False))],
    cookie: Annotated[str | None, Depends(APIKeyCookie(name=COOKIE, auto_error=False))],
) -> str | None:
    return bearer.credentials if bearer else cookie


#: The token that came with a request, good or not.
Given = Annotated[str | None, Depends(_given)]


class Exposed(RuntimeError):  # noqa: N818 - the name says what is wrong
    """The service would be open to other machines; the text says what would be right."""

    def __init__(self, host: str) -> None:
        super().__init__(
            f"{host} can be reached from other machines, and no token is valid: make one with "
            "`woodcock token create NAME`, or let everybody in with --insecure."
        )


def protect(engine: Engine, host: str) -> None:
    """Raises Exposed where others could reach a service that asks nobody who they are."""
    with engine.connect() as connection:
        guarded = tokens.usable(connection, datetime.now(UTC))
    if not (guarded or is_loopback(host)):
        raise Exposed(host)


def is_loopback(host: str) -> bool:
    try:
        found = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)
    except OSError:  # Listening there will fail, and say so.
        return False
    return all(ipaddress.ip_address(str(address[0]).partition("%")[0]).is_loopback for *_, address in found)


def authorized(request: Request, services: Provided, token: Given) -> str:
    """Of every route but the public ones; returns whose token it is, "" where nobody needs one."""
    found = _require(services, token, Scope.READ if request.method in READING else Scope.WRITE)
    return str(found["owner"]) if found else ""


#: Who asks.
Owner = Annotated[str, Depends(authorized)]


def administrator(services: Provided, token: Given) -> None:
    """Of routes that only admins may ask."""
    _require(services, token, Scope.ADMIN)


def holder(services: Services, text: str | None) -> tokens.Row | None:
    """Whose token it is; None for nobody where nobody needs one. Raises HTTPException 401."""
    if services.insecure:
        return None
    with services.engine.connect() as connection:
        found = tokens.find(connection, text, datetime.now(UTC)) if text else None
        if found is not None or not tokens.made(connection):
            return found
    says = (
        "The token is unknown or revoked, or has expired."
        if text
        else "This service asks for a token: sign in at /, or send it as `Authorization: Bearer`."
    )
    raise HTTPException(401, says, headers={"WWW-Authenticate": "Bearer"})


def _require(services: Services, text: str | None, scope: Scope) -> tokens.Row | None:
    found = holder(services, text)
    if found is not None and not Scope(found["scope"]).holds(scope):
        raise HTTPException(403, f"The token {found['name']} is good for `{found['scope']}`; this needs `{scope}`.")
    return found
