"""ASGI middleware: by which name and from which site the service is asked, and what its answers forbid browsers."""

from __future__ import annotations

from collections.abc import Collection
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from woodcock_server.access.guard import READING
from woodcock_server.problems import respond

LOOPBACK = ("127.0.0.1", "::1", "localhost")
#: Of every answer that does not say otherwise.
ALWAYS = {
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
}


class SameOrigin:
    """Refuses names that are not the service's, by which another site's page would count as of this one, and changes
    that pages of other sites ask for.

    names: hosts; empty for any.
    """

    def __init__(self, app: ASGIApp, names: Collection[str]) -> None:
        self.app = app
        self.names = names

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self.app(scope, receive, send)

        async def careful(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in ALWAYS.items():
                    headers.setdefault(name, value)
            await send(message)

        headers = Headers(scope=scope)
        host = headers.get("host", "")
        name = urlsplit(f"//{host}").hostname if _is_host(host) else None
        if self.names and name not in self.names:
            says = "This service does not go by that name; WOODCOCK_NAMES has those by which it does."
            return await respond(421, says)(scope, receive, careful)
        foreign = headers.get("sec-fetch-site") == "cross-site" or _host(headers.get("origin")) not in (None, host)
        if foreign and scope["method"] not in READING:
            return await respond(403, "Pages of other sites may not change anything here.")(scope, receive, careful)
        return await self.app(scope, receive, careful)


def _is_host(host: str) -> bool:
    try:
        return bool(urlsplit(f"//{host}").netloc == host and "@" not in host)
    except ValueError:
        return False


def _host(origin: str | None) -> str | None:
    """Host and port of an Origin; "" for one that has none, such as a sandboxed page's `null`."""
    if origin is None:
        return None
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return ""
