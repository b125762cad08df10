"""Grids that are looked at: read once, kept for a while."""

from __future__ import annotations

import asyncio
from collections import OrderedDict

from anyio import to_thread

from woodcock_server.storage import Storage
from woodcock_server.volumes.parser import Parser
from woodcock_server.volumes.samples import Samples

#: Bytes that are kept of all grids.
ROOM = 1 << 26


class Slices:
    """What was looked at lately. One grid is read at a time, so that uploads keep a turn of the parser's."""

    def __init__(self, parser: Parser, storage: Storage) -> None:
        self._parser = parser
        self._storage = storage
        self._kept = OrderedDict[tuple[str, int], Samples]()
        self._reading = asyncio.Lock()

    async def samples(self, volume_id: str, position: int) -> Samples:
        """Of the grid at a position of an uploaded file. Raises UnreadableFile."""
        key = volume_id, position
        if key not in self._kept:
            async with self._reading:
                if key not in self._kept:
                    self._kept[key] = await to_thread.run_sync(
                        self._sample, volume_id, position, limiter=self._parser.turns
                    )
                    self._drop()
        self._kept.move_to_end(key)
        return self._kept[key]

    def _sample(self, volume_id: str, position: int) -> Samples:
        return self._parser.sample(self._storage.volume_file(volume_id), position)

    def _drop(self) -> None:
        while len(self._kept) > 1 and sum(len(each.values) for each in self._kept.values()) > ROOM:
            self._kept.popitem(last=False)
