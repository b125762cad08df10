"""In-process publish and subscribe: who waits for a job learns that its row has changed.

The message is the change alone. A subscriber reads the row, so it never sees what the database does not hold, and a
burst of changes costs it one reading.
"""

from __future__ import annotations

import asyncio
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager, suppress


class Changes:
    """Changes of jobs, by id. For the event loop's thread only."""

    def __init__(self) -> None:
        self._subscribers: defaultdict[str, set[asyncio.Event]] = defaultdict(set)
        self.closed = False

    def publish(self, job_id: str) -> None:
        """The job's row has changed."""
        for event in self._subscribers.get(job_id, ()):
            event.set()

    @property
    def followed(self) -> list[str]:
        """Jobs that somebody waits for."""
        return list(self._subscribers)

    @contextmanager
    def subscribe(self, job_id: str) -> Iterator[asyncio.Event]:
        """An event that is set at every change from now on; the subscriber clears it."""
        event = asyncio.Event()
        self._subscribers[job_id].add(event)
        try:
            yield event
        finally:
            self._subscribers[job_id].discard(event)
            if not self._subscribers[job_id]:
                del self._subscribers[job_id]

    def close(self) -> None:
        """The server stops: wake every subscriber, to let it go."""
        self.closed = True
        for events in self._subscribers.values():
            for event in events:
                event.set()


async def wait(event: asyncio.Event, seconds: float) -> None:
    """Return when the event is set, or after so many seconds; the event is clear afterwards."""
    with suppress(TimeoutError):
        await asyncio.wait_for(event.wait(), seconds)
    event.clear()
