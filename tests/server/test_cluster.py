"""What others wait for outlives one who stops waiting."""

from __future__ import annotations

import asyncio
import math
import time
from pathlib import Path

import pytest
from distributed import Future, batched
from distributed.batched import BatchedSend

from woodcock_server.cluster import ask, embedded
from woodcock_server.steady import keep_time


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


class Wire:
    """A connection that takes what is sent."""

    def __init__(self) -> None:
        self.sent: list[object] = []

    async def write(self, messages: list[object], **_: object) -> int:
        self.sent += messages
        return 1

    def closed(self) -> bool:
        return False


async def set_back(clock: list[float]) -> list[object]:
    """What is sent although the clock is set back just after a message."""
    keep_time()
    wire, sender = Wire(), BatchedSend("50ms")  # type: ignore[no-untyped-call]
    sender.start(wire)
    sender.send("before")
    while not wire.sent:
        await asyncio.sleep(0.001)
    clock[0] = -86400
    sender.send("after")
    await asyncio.sleep(0.5)
    sender.please_stop = True
    sender.waker.set()
    return wire.sent


def test_messages_go_on_when_the_clock_is_set_back(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, now = [0.0], time.time

    def wall() -> float:
        return now() + clock[0]

    monkeypatch.setattr(time, "time", wall)
    for name, value in (("time", wall), ("locks", batched.locks)):  # as they are before, and again afterwards
        monkeypatch.setattr(batched, name, value)
    assert asyncio.run(set_back(clock)) == ["before", "after"]
