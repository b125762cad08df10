"""Dask's messages by a clock that nobody sets.

What it sends at once it joins, for some milliseconds after the last message, up to a time of the wall clock. Set back
by a day in these milliseconds, it would send nothing for a day.
"""

from __future__ import annotations

import time
from collections.abc import Awaitable
from datetime import timedelta
from types import SimpleNamespace

from distributed import batched
from tornado.locks import Event


class _Waker(Event):
    def wait(self, timeout: float | timedelta | None = None) -> Awaitable[None]:
        """timeout: when to wait no longer, by the monotonic clock."""
        if isinstance(timeout, float):
            timeout = timedelta(seconds=max(0.0, timeout - time.monotonic()))
        return super().wait(timeout)


def keep_time() -> None:
    """For this process's connections from now on."""
    for name, value in (("time", time.monotonic), ("locks", SimpleNamespace(Event=_Waker))):
        setattr(batched, name, value)
