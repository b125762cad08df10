"""One POST to a receiver that nobody vouches for: in bounded time and memory, and to no internal address."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from contextlib import aclosing
from urllib.parse import urlsplit

import httpcore2

from woodcock import __version__
from woodcock_server.webhooks.network import Network, PublicNetwork

#: So much of an answer is heard before the connection is closed, bytes.
HEARD = 1 << 16
#: So much of what went wrong is told, characters.
TOLD = 300

#: What may go wrong between here and there.
FAILURES = (TimeoutError, httpcore2.TimeoutException, httpcore2.NetworkError, httpcore2.ProtocolError)


class Undelivered(RuntimeError):  # noqa: N818 - it says what happened
    """An attempt failed; the text says why. final: another one would be in vain."""

    def __init__(self, reason: str, final: bool = False) -> None:
        super().__init__(reason[:TOLD])
        self.final = final


class Sender:
    """allowed: internal networks that receivers may be in. limit: of one POST, seconds."""

    def __init__(self, allowed: Sequence[Network], limit: float) -> None:
        self._limit = limit
        self._network = PublicNetwork(allowed)
        self._tls = httpcore2.default_ssl_context()

    def close(self) -> None:
        self._network.close()

    async def post(self, url: str, headers: dict[str, str], body: bytes) -> int:
        """The status of the answer; no redirect is followed, no proxy asked. Raises Undelivered for none."""
        sent = {
            "Host": urlsplit(url).netloc,
            "User-Agent": f"Woodcock/{__version__}",
            "Content-Type": "application/json",
            **headers,
        }
        status = heard = 0
        try:
            async with (
                asyncio.timeout(self._limit),
                httpcore2.AsyncConnectionPool(self._tls, network_backend=self._network) as pool,
                pool.stream("POST", url, headers=list(sent.items()), content=body) as answer,
            ):
                status = answer.status
                # Who is cut off while he answers takes it for a failure; but he may not go on for ever.
                async with aclosing(answer.aiter_stream()) as parts:
                    async for part in parts:
                        heard += len(part)
                        if heard > HEARD:
                            break
        except FAILURES as error:
            if not status:
                raise Undelivered(_reason(error)) from None
        return status


def _reason(error: Exception) -> str:
    if isinstance(error, TimeoutError | httpcore2.TimeoutException):
        return "No answer in time."
    return f"No answer: {str(error) or type(error).__name__}."
