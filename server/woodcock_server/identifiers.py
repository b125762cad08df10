"""Identifiers that sort by time: UUID version 7 (RFC 9562, 5.7), with fractions of a millisecond (6.2, method 3)."""

from __future__ import annotations

import secrets
import threading
import time
import uuid

#: What an identifier looks like, for query parameters.
PATTERN = r"^[0-9a-f]{8}-[0-9a-f]{4}-7[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}$"

_lock = threading.Lock()
_last = 0


def new_id() -> str:
    """A new identifier, greater than every one that this process made before."""
    global _last
    nanoseconds = time.time_ns()
    ticks = (nanoseconds // 1_000_000 << 12) | (nanoseconds % 1_000_000 * 4096 // 1_000_000)
    with _lock:
        _last = max(ticks, _last + 1)
        ticks = _last
    milliseconds, fraction = ticks >> 12, ticks & 0xFFF
    return str(uuid.UUID(int=milliseconds << 80 | 7 << 76 | fraction << 64 | 2 << 62 | secrets.randbits(62)))
