"""Publish and subscribe within the process."""

from __future__ import annotations

import asyncio
import time

from woodcock_server.events import Changes, wait


def test_a_subscriber_learns_of_its_job_alone() -> None:
    async def scenario() -> None:
        changes = Changes()
        with changes.subscribe("a") as a, changes.subscribe("a") as again, changes.subscribe("b") as b:
            changes.publish("a")
            assert (a.is_set(), again.is_set(), b.is_set()) == (True, True, False)
            await wait(a, 10)
            assert not a.is_set(), "a change is told once"
            changes.publish("nobody waits for this one")

    asyncio.run(scenario())


def test_waiting_ends_with_its_time() -> None:
    async def scenario() -> None:
        began = time.monotonic()
        await wait(asyncio.Event(), 0.05)
        assert 0.04 < time.monotonic() - began < 5

    asyncio.run(scenario())


def test_closing_wakes_everyone() -> None:
    async def scenario() -> None:
        changes = Changes()
        with changes.subscribe("a") as a, changes.subscribe("b") as b:
            changes.close()
            assert changes.closed
            await wait(a, 10)
            await wait(b, 10)

    asyncio.run(scenario())
