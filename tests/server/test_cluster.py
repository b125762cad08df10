"""What others wait for outlives one who stops waiting."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path

import pytest
from distributed import Future

from woodcock_server.cluster import ask, embedded


async def one_gives_up(scratch: Path) -> list[float]:
    async with embedded(["one"], scratch, 4 << 30) as client:
        # Five gatherings at a time are all that Dask does; with these taken, results wait at the client to be fetched.
        taken = client._gather_semaphore
        for _ in range(5):
            await taken.acquire()
        first = asyncio.create_task(ask(client, "one", "first", math.sqrt, 1))
        second = asyncio.create_task(ask(client, "one", "second", math.sqrt, 4))
        while client._gather_future is None:
            await asyncio.sleep(0.01)
        await asyncio.sleep(0.2)
        first.cancel()
        await asyncio.wait({first})
        assert first.cancelled()
        for _ in range(5):
            taken.release()
        return [await second, await ask(client, "one", "third", math.sqrt, 9)]


def test_one_who_gives_up_takes_nothing_from_others(tmp_path: Path) -> None:
    assert asyncio.run(asyncio.wait_for(one_gives_up(tmp_path), 60)) == [2, 3]


async def forgotten(scratch: Path) -> None:
    async with embedded(["one"], scratch, 4 << 30) as client:
        waiting = asyncio.create_task(ask(client, "one", "long", asyncio.sleep, 60))
        while "long" not in client.futures:
            await asyncio.sleep(0.01)
        await client.cancel([Future("long", client)])  # type: ignore[no-untyped-call]
        await waiting


def test_what_the_cluster_gives_up_is_a_fault(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match="gave up sleep on one"):
        asyncio.run(asyncio.wait_for(forgotten(tmp_path), 60))
