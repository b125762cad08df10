"""ASGI middleware: how often one address may ask. Who comes too often is told when to come again."""

from __future__ import annotations

import math
import time
from collections import OrderedDict

from starlette.types import ASGIApp, Receive, Scope, Send

from woodcock_server.problems import respond

#: Seconds' worth of requests that may come at once.
BURST_SECONDS = 10
#: Addresses that are remembered; who asked longest ago is forgotten first, and begins anew.
REMEMBERED = 10_000


class RateLimit:
    """A token bucket for each address.

    rate: requests a second.
    """

    def __init__(self, app: ASGIApp, rate: float) -> None:
        self.app = app
        self.rate, self.most = rate, max(1.0, rate * BURST_SECONDS)
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()  # requests left, as of when

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or (wait := self._wait(scope["client"], time.monotonic())) <= 0:
            return await self.app(scope, receive, send)
        says = f"More than {self.rate:g} requests a second came from this address for a while."
        return await respond(429, says, headers={"Retry-After": str(math.ceil(wait))})(scope, receive, send)

    def _wait(self, client: tuple[str, int] | None, now: float) -> float:
        """Take one request; seconds until it may come, 0 for now."""
        address = client[0] if client else ""
        left, then = self._buckets.pop(address, (self.most, now))
        left = min(self.most, left + (now - then) * self.rate)
        self._buckets[address] = (left - 1 if left >= 1 else left, now)
        if len(self._buckets) > REMEMBERED:
            self._buckets.popitem(last=False)
        return 0 if left >= 1 else (1 - left) / self.rate
