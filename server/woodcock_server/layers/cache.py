"""What was read of files and is asked for again soon, within bounds of memory."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable

import numpy as np
from numpy.typing import NDArray

Channels = dict[str, NDArray[np.float32]]


class Cache:
    """Channels by key; those that were longest not asked for go when all take more than `limit` bytes."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._held: OrderedDict[Hashable, Channels] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: Hashable, read: Callable[[], Channels]) -> Channels:
        """What `read` returned for the key, now or before. What takes more than the limit is not kept."""
        with self._lock:
            if key in self._held:
                self._held.move_to_end(key)
                return self._held[key]
        found = read()
        if _size(found) > self._limit:
            return found
        with self._lock:
            self._held[key] = found
            while sum(map(_size, self._held.values())) > self._limit:
                self._held.popitem(last=False)
        return found


def _size(channels: Channels) -> int:
    return sum(each.nbytes for each in channels.values())
